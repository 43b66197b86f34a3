//! The crystal: how it grows, what it is made of, where it ends, and what the base has to do with
//! it.

use super::column::Column;
use super::crystal::Crystal;
use super::lattice::{best_fit, lattice_constant};
use super::layers::{PAPERS_LAYERS, mean_lateral_density, mean_spacing, theory_spacing};
use super::protocol::Protocol;
use super::results::{COLORS, Results, front_of, frozen_theory};
use gradient_mc::observers::StructurePoint;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::row;
use paper::table::Table;
use paper::verdict::Verdicts;
use paper::{Failure, Report};

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let theory = frozen_theory(Column { rate: Protocol::CRYSTAL_RATE, base: crystal.base })?;
    let last = results.crystals.iter().filter_map(|crystal| crystal.history.last()).map(|stand| stand.sweep);
    let end = last.max().unwrap_or(1) as f64;
    let mut height = Panel::new(
        Place { left: 0.0, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("sweeps / 10³", 0.0, end / 1e3),
        Axis::new("height of the uppermost crystalline layer / d", 0.0, 45.0),
    )
    .with_title("growth of all crystals")
    .with_legend(Corner::TopLeft)
    .line(
        "coexistence, hydrostatics",
        colors::INK,
        Mark::Dashed,
        [(0.0, front_of(&theory)), (end / 1e3, front_of(&theory))],
    );
    for (index, crystal) in results.crystals.iter().enumerate() {
        let stands = crystal.history.iter().map(|stand| Point {
            x: stand.sweep as f64 / 1e3,
            y: stand.height,
            error: 0.0,
        });
        let label = format!("base {}", crystal.base);
        height =
            height.points(&label, COLORS[(COLORS.len() - 1 + index) % COLORS.len()], Mark::Points, stands);
    }
    let mut made_of = Panel::new(
        Place { left: 0.5, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("height x / d", 0.0, 40.0),
        Axis::new("share of the spheres", 0.0, 1.6),
    )
    .with_title(&format!("local structure, base {}", crystal.base))
    .with_legend(Corner::TopRight);
    let points = crystal.structure.points()?;
    for (label, color, share) in [
        ("face-centered cubic", colors::BLUE, 0),
        ("hexagonal close-packed", colors::VERMILION, 1),
        ("neither", colors::GRAY, 2),
    ] {
        let shares = points.iter().map(|point| (point.height, shares(point)[share]));
        let shares = shares.filter(|share| share.1.mean.is_finite());
        made_of = made_of.points(label, color, Mark::Points, shares.map(|(x, share)| Point::of(x, share)));
    }
    let front = crystal.fronts()?.bonds.mean;
    made_of = made_of.line(
        "front: half of the spheres are crystalline",
        colors::INK,
        Mark::Dashed,
        [(front, 0.0), (front, 1.05)],
    );
    let figure = Figure::new("The crystal at α = 0.1, grown from the fluid   (T = 20, N/A = 40)")
        .panel(height)
        .panel(made_of);
    report.picture(
        "crystal",
        &figure,
        "The crystal at α = 0.1: its growth, and the shares of fcc, hcp and fluid spheres against height",
    )?;
    write(results, report)
}

fn write(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let histories = results.crystals.iter().enumerate().flat_map(|(index, crystal)| {
        crystal.history.iter().map(move |stand| {
            [
                index as f64,
                stand.sweep as f64,
                stand.rate,
                stand.center_of_mass,
                stand.layers as f64,
                stand.height,
            ]
        })
    });
    report.table(
        "crystal_growth",
        "crystal: number in the order of the table; alpha in 1/d at the time; heights in d",
        "crystal, sweep, alpha, center_of_mass, crystalline_layers, height_of_uppermost",
        histories,
    )?;
    let mut rows = Vec::new();
    for (index, crystal) in results.crystals.iter().enumerate() {
        for point in crystal.structure.points()? {
            let [cubic, hexagonal, neither] = shares(&point);
            rows.push(row![index as f64, point.height, cubic, hexagonal, neither,]);
        }
    }
    report.table("crystal_structure",
        "crystal: number in the order of the table; heights in d, bins of 1 d; shares of the spheres there; errors are one standard error",
        "crystal, height, face_centered_cubic, face_centered_cubic_error, \
         hexagonal_close_packed, hexagonal_close_packed_error, neither, neither_error",
        rows,
    )
}

/// One column per crystal.
pub(crate) fn table(results: &Results) -> Result<Table, Failure> {
    let heads =
        results.crystals.iter().enumerate().map(|(index, crystal)| format!("{index}: {}", crystal.base));
    let mut table = Table::new(std::iter::once("crystal: base".to_owned()).chain(heads));
    let mut row = |label: &str, cell: &dyn Fn(&Crystal) -> Result<String, Failure>| -> Result<(), Failure> {
        let cells = results.crystals.iter().map(cell).collect::<Result<Vec<String>, Failure>>()?;
        table.row(label, cells);
        Ok(())
    };
    let theory =
        |crystal: &Crystal| frozen_theory(Column { rate: Protocol::CRYSTAL_RATE, base: crystal.base });
    row("spheres", &|crystal| Ok(crystal.particles.to_string()))?;
    row("sweeps of growth, of production", &|crystal| {
        Ok(format!("{}, {}", crystal.growth_sweeps, crystal.sweeps))
    })?;
    row("center of mass / d", &|crystal| Ok(crystal.center_of_mass.estimate()?.to_string()))?;
    row("  drift during production", &|crystal| Ok(crystal.center_of_mass.drift()?.to_string()))?;
    row("  hydrostatics, unstrained crystal", &|crystal| {
        Ok(format!("{:.3}", theory(crystal)?.center_of_mass()))
    })?;
    row("crystalline layers", &|crystal| Ok(crystal.crystalline_layers()?.len().to_string()))?;
    row("spacing of the lowest 20 / d", &|crystal| {
        Ok(mean_spacing(&crystal.crystalline_layers()?).to_string())
    })?;
    row("  hydrostatics, unstrained crystal", &|crystal| {
        let theory = theory(crystal)?;
        let layers = crystal.crystalline_layers()?;
        let inner = layers.iter().skip(1).take(PAPERS_LAYERS - 1);
        let spacings: Vec<f64> = inner.map(|layer| theory_spacing(&theory, layer.position.mean)).collect();
        Ok(format!("{:.4}", spacings.iter().sum::<f64>() / spacings.len() as f64))
    })?;
    row("spheres in a layer, mean", &|crystal| {
        let lateral = mean_lateral_density(&crystal.crystalline_layers()?);
        let area = crystal.base.0[0] * crystal.base.0[1];
        Ok((area * lateral).to_string())
    })?;
    row("  of the best fitting lattice with a = 1.08", &|crystal| {
        let fit = best_fit(crystal.base, REFERENCE_CONSTANT).ok_or("no lattice fits")?;
        Ok(format!("{} ({:+.1} %, shear {:.1} %)", fit.spheres, 100.0 * fit.areal(), 100.0 * fit.shear()))
    })?;
    row("lateral strain against hydrostatics: base, middle, front / %", &|crystal| {
        let strains = lateral_strains(crystal)?;
        Ok(strains.map(|strain| format!("{strain:+.1}")).join(", "))
    })?;
    row("fcc, hcp, fluid / %, 2 d to front − 2 d", &|crystal| {
        let composition = composition(crystal)?;
        Ok(composition.map(|share| format!("{:.0}", 100.0 * share.mean)).join(", "))
    })?;
    row("front / d: half of the spheres are crystalline", &|crystal| {
        Ok(crystal.fronts()?.bonds.to_string())
    })?;
    row("  visibility of the layers below 0.7", &|crystal| Ok(crystal.fronts()?.layers.to_string()))?;
    row("  displacement midway between crystal and fluid", &|crystal| {
        Ok(crystal.fronts()?.mobility.to_string())
    })?;
    row("  where P/T is that of coexistence", &|crystal| Ok(crystal.fronts()?.pressure.to_string()))?;
    row("  hydrostatics", &|crystal| Ok(format!("{:.2}", front_of(&theory(crystal)?))))?;
    row("CPU time / s", &|crystal| Ok(format!("{:.0}", crystal.busy)))?;
    Ok(table)
}

/// Half way up the crystal of theory neighbors are about as far apart.
const REFERENCE_CONSTANT: f64 = 1.08;

/// How much wider the layers are than those of an unstrained crystal at the pressure of theory, at
/// the second layer, half way up and two diameters below the front.
fn lateral_strains(crystal: &Crystal) -> Result<[f64; 3], Failure> {
    let theory = frozen_theory(Column { rate: Protocol::CRYSTAL_RATE, base: crystal.base })?;
    let layers = crystal.crystalline_layers()?;
    let front = front_of(&theory);
    let strain = |height: f64| {
        let nearest = layers.iter().skip(1).min_by(|first, second| {
            let distance = |layer: &gradient_mc::observers::Layer| (layer.position.mean - height).abs();
            distance(first).total_cmp(&distance(second))
        });
        nearest.map_or(f64::NAN, |layer| {
            let constant = (2.0 / (3.0_f64.sqrt() * layer.lateral_density.mean)).sqrt();
            100.0 * (constant / lattice_constant(theory.number_density(layer.position.mean)) - 1.0)
        })
    };
    Ok([strain(1.0), strain(0.5 * front), strain(front - 2.0)])
}

/// Shares between two diameters above the base and two below the front.
fn composition(crystal: &Crystal) -> Result<[Estimate; 3], Failure> {
    let front = crystal.fronts()?.bonds.mean;
    Ok(shares(&crystal.structure.over(2.0, front - 2.0)?))
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let fronts = crystal.fronts()?;
    let difference = |first: Estimate, second: Estimate| first.minus_independent(second);
    let off = difference(fronts.layers, fronts.bonds);
    verdicts.between("crystal", "front by layers minus front by bonds, in d", off, -1.5, 1.5);
    // Hydrostatics does not describe a crystal with lateral strain; the weight that lies on the
    // front does.
    let off = difference(fronts.bonds, fronts.pressure);
    let claim = "front by bonds minus height at which the measured P/T is that of coexistence, in d";
    verdicts.between("crystal", claim, off, -1.5, 1.5);
    let [_, _, neither] = composition(crystal)?;
    let claim = "share of crystalline spheres between 2 d and front − 2 d";
    verdicts.at_least("crystal", claim, 1.0 - neither, 0.8);
    Ok(())
}

/// Shares of face-centered, hexagonal, and neither.
fn shares(point: &StructurePoint) -> [Estimate; 3] {
    [point.face_centered_cubic, point.hexagonal_close_packed, point.fluid]
}
