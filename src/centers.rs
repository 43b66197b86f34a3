//! The centers of all spheres, gathered lazily.

use crate::configuration::Configuration;

/// The centers of the spheres of a configuration, in diameters.
///
/// Moves keep the spheres sorted by position, not by number. Heights in arbitrary order need no
/// sorting; positions by number are sorted once after a sweep, at the first request.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Centers<'a>(Source<'a>);

#[derive(Debug, Clone, Copy)]
enum Source<'a> {
    Configuration(&'a Configuration),
    /// Made by hand, for tests.
    #[cfg(test)]
    List(&'a [[f64; 3]]),
}

impl<'a> Centers<'a> {
    pub(crate) fn new(configuration: &'a Configuration) -> Self {
        Self(Source::Configuration(configuration))
    }

    #[cfg(test)]
    pub(crate) fn listed(positions: &'a [[f64; 3]]) -> Self {
        Self(Source::List(positions))
    }

    /// Number of spheres.
    pub(crate) fn count(self) -> usize {
        match self.0 {
            Source::Configuration(configuration) => configuration.len(),
            #[cfg(test)]
            Source::List(positions) => positions.len(),
        }
    }

    /// Calls `visit` with the height of each sphere, in arbitrary order.
    pub(crate) fn for_each_height(self, visit: impl FnMut(f64)) {
        match self.0 {
            Source::Configuration(configuration) => configuration.heights().for_each(visit),
            #[cfg(test)]
            Source::List(positions) => positions.iter().map(|position| position[0]).for_each(visit),
        }
    }

    /// Positions x, y, z. The order of the spheres is the same during the whole run.
    pub(crate) fn positions(self) -> &'a [[f64; 3]] {
        match self.0 {
            Source::Configuration(configuration) => configuration.positions(),
            #[cfg(test)]
            Source::List(positions) => positions,
        }
    }
}
