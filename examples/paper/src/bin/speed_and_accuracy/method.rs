//! The methods of simulating a column.

use crate::system::System;
use std::fmt;

/// The moves of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Moves {
    /// S = 0.75, as in the paper.
    Paper,
    Tuned,
    /// Event chains, and tuned local moves between them.
    ChainsAndTuned,
    ChainsAlone,
    /// Event chains alone, half of them lateral, with the equation of state from their collisions;
    /// above the layers n and P are those of hydrostatics with this equation.
    OwnEquation,
}

impl Moves {
    pub(crate) const ALL: [Self; 5] =
        [Self::Paper, Self::Tuned, Self::ChainsAndTuned, Self::ChainsAlone, Self::OwnEquation];

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Paper => "local moves, S = 0.75",
            Self::Tuned => "tuned local moves",
            Self::ChainsAndTuned => "chains and tuned moves",
            Self::ChainsAlone => "event chains alone",
            Self::OwnEquation => "event chains, own equation of state",
        }
    }
}

/// Initial configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Start {
    Uniform,
    /// Only references start here.
    ClosePacked,
    Theory,
}

impl Start {
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Uniform => "random start",
            Self::ClosePacked => "close-packed start",
            Self::Theory => "theory start",
        }
    }
}

/// Scheme of the effective field if the temperature varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scheme {
    SelfConsistent,
    Closure,
    RunningAverage,
    AveragedThenFrozen,
    Instantaneous,
}

impl Scheme {
    pub(crate) const ALL: [Self; 5] = [
        Self::SelfConsistent,
        Self::Closure,
        Self::RunningAverage,
        Self::AveragedThenFrozen,
        Self::Instantaneous,
    ];

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::SelfConsistent => "self-consistent",
            Self::Closure => "closure",
            Self::RunningAverage => "running average",
            Self::AveragedThenFrozen => "averaged, then frozen",
            Self::Instantaneous => "instantaneous",
        }
    }
}

/// Sides of the bases.
pub(crate) const SMALL: f64 = 5.0;
pub(crate) const FULL: f64 = 25.0;

/// One way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Method {
    pub(crate) moves: Moves,
    pub(crate) start: Start,
    /// Side of the square base.
    pub(crate) width: f64,
    /// Not used in isothermal systems.
    pub(crate) scheme: Scheme,
}

impl Method {
    /// All ways of simulating a system: moves, starts and bases with the scheme by default; and
    /// with tuned moves from the theory start the other schemes, where there is a choice.
    pub(crate) fn all(system: System) -> Vec<Self> {
        let mut methods = Vec::new();
        for width in [SMALL, FULL] {
            for moves in Moves::ALL {
                for start in [Start::Uniform, Start::Theory] {
                    methods.push(Self { moves, start, width, scheme: Scheme::SelfConsistent });
                }
            }
            if system == System::VaryingTemperature {
                for scheme in Scheme::ALL.into_iter().filter(|&scheme| scheme != Scheme::SelfConsistent) {
                    methods.push(Self { moves: Moves::Tuned, start: Start::Theory, width, scheme });
                }
            }
        }
        methods
    }

    /// Whether the base is the full one.
    pub(crate) fn is_full(&self) -> bool {
        self.width > 0.5 * (SMALL + FULL)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}, {}, {2} x {2}", self.moves.label(), self.start.label(), self.width)?;
        match self.scheme {
            Scheme::SelfConsistent => Ok(()),
            scheme => write!(formatter, ", {}", scheme.label()),
        }
    }
}
