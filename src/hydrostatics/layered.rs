//! Profiles of density functionals as hydrostatic profiles.

use super::HydrostaticProfile;
use super::march::Panel;
use super::profile::Cumulated;
use crate::equation_of_state::packing_fraction;
use crate::legendre::{Legendre, ORDER, Series, evaluate};

impl HydrostaticProfile {
    /// Base, inner edges of the panels, and top.
    pub(crate) fn edges(&self) -> impl DoubleEndedIterator<Item = f64> + '_ {
        std::iter::once(self.base).chain(self.panels.iter().map(|panel| panel.end))
    }

    /// The profile with other ln n and ln P, given at the nodes of `panels`. Beyond them it is
    /// continued by the old profile, times a factor.
    pub(crate) fn with_layers(
        &self,
        rule: &Legendre,
        panels: &[[f64; 2]],
        [ln_densities, ln_pressures]: [&[f64]; 2],
        base: f64,
    ) -> Self {
        let at = |panel: usize, values: &[f64]| -> Series {
            std::array::from_fn(|node| values[panel * ORDER + node])
        };
        let inner: Vec<Panel> = panels
            .iter()
            .enumerate()
            .map(|(index, &[start, end])| {
                let ln_density = at(index, ln_densities);
                Panel::of_values(rule, [start, end], base, &ln_density, &at(index, ln_pressures))
            })
            .collect();
        let ends =
            [panels.first().map_or(base, |panel| panel[0]), panels.last().map_or(base, |panel| panel[1])];
        let shift = |end: usize| {
            let panel = if end == 0 { inner.first() } else { inner.last() };
            panel.map_or(0.0, |panel| libm::log(panel.edges[end] / self.number_density(ends[end])))
        };
        let shifts = [shift(0), shift(1)];
        let outer = |panel: &Panel, shift: f64| panel.scaled(shift, self.base - base);
        let mut all: Vec<Panel> = self
            .panels
            .iter()
            .filter(|panel| panel.end <= ends[0])
            .map(|panel| outer(panel, shifts[0]))
            .collect();
        all.extend(inner);
        all.extend(
            self.panels.iter().filter(|panel| panel.start >= ends[1]).map(|panel| outer(panel, shifts[1])),
        );
        let Cumulated { below, above, column_density } = Cumulated::of(&all);
        let moment: f64 = all.iter().map(|panel| panel.moment).sum();
        let heights = all.iter().flat_map(|panel| {
            let inside =
                rule.nodes.into_iter().map(|t| (panel.height(t), libm::exp(evaluate(&panel.ln_density, t))));
            [(panel.start, panel.edges[0]), (panel.end, panel.edges[1])].into_iter().chain(inside)
        });
        let density_maximum =
            heights.fold(
                (base, 0.0),
                |best, (height, density)| if density > best.1 { (height, density) } else { best },
            );
        let pressure = |panel: Option<&Panel>, t: f64| {
            panel.map_or(f64::NEG_INFINITY, |panel| evaluate(&panel.ln_pressure, t))
        };
        Self {
            base: all.first().map_or(base, |panel| panel.start),
            top: all.last().map_or(base, |panel| panel.end),
            column_density,
            center_of_mass: base + moment / column_density,
            ln_base_pressure: pressure(all.first(), -1.0),
            base_packing_fraction: all.first().map_or(0.0, |panel| packing_fraction(panel.edges[0])),
            lid_pressure: libm::exp(pressure(all.last(), 1.0)),
            density_maximum,
            domain_exit: None,
            deviation: 0.0,
            panels: all,
            below,
            above,
        }
    }
}

impl Panel {
    fn of_values(
        rule: &Legendre,
        [start, end]: [f64; 2],
        base: f64,
        ln_densities: &Series,
        ln_pressures: &Series,
    ) -> Self {
        let half = 0.5 * (end - start);
        let densities = ln_densities.map(libm::exp);
        let moments =
            std::array::from_fn(|node| (start + half * (rule.nodes[node] + 1.0) - base) * densities[node]);
        let ln_density = rule.coefficients(ln_densities);
        Self {
            start,
            end,
            ln_density,
            ln_pressure: rule.coefficients(ln_pressures),
            density: rule.coefficients(&densities),
            jump: false,
            edges: [-1.0, 1.0].map(|t| libm::exp(evaluate(&ln_density, t))),
            mass: half * rule.integrate(&densities),
            moment: half * rule.integrate(&moments),
        }
    }

    /// The panel with its density times e^`shift`, and moments about a base that is lower by
    /// `rise`.
    fn scaled(&self, shift: f64, rise: f64) -> Self {
        let factor = libm::exp(shift);
        let mut panel = self.clone();
        panel.ln_density[0] += shift;
        panel.ln_pressure[0] += shift;
        panel.density.iter_mut().chain(&mut panel.edges).for_each(|value| *value *= factor);
        panel.mass *= factor;
        panel.moment = factor * self.moment + rise * panel.mass;
        panel
    }
}
