use gradient_mc::{drive::*, field::*, moves::*, observers::*, start, temperature::*, *};
use std::time::Instant;
fn go<S: Scheme<UniformField, ExponentialTemperature>, P: start::Start>(
    name: &str,
    w: f64,
    beta: f64,
    scheme: S,
    start: P,
    eq: u64,
    prod: u64,
) -> Result<(), Error> {
    let n = (40.0 * w * w) as usize;
    let scene = Scene::new(
        Slab::new(400.0, w, w)?,
        n,
        UniformField::default(),
        ExponentialTemperature::new(20.0, beta)?,
    )?;
    let mut s = Simulation::builder(scene)
        .scheme(scheme)
        .start(start)
        .seed(1)
        .moves(EventChains::default())
        .build()?;
    let t0 = Instant::now();
    print!("{name}: ");
    for _ in 0..8 {
        let mut cm = CenterOfMass::new();
        s.equilibrate(eq / 8, &mut cm)?;
        print!("{:.2} ", cm.heights().iter().sum::<f64>() / cm.heights().len() as f64);
    }
    print!(" | ");
    let mut prof = EquationOfStateProfile::new(s.scene().slab(), 40)?;
    let mut cp = ChainPressureProfile::new(s.scene().slab(), 40)?;
    for _ in 0..4 {
        let mut cm = CenterOfMass::new();
        s.run(prod / 4, &mut (&mut cm, &mut prof, &mut cp))?;
        print!("{:.2} ", cm.heights().iter().sum::<f64>() / cm.heights().len() as f64);
    }
    println!(" {:.1}s", t0.elapsed().as_secs_f64());
    use equation_of_state::*;
    let dev = prof.deviations_from(|e| FluidSolid::default().compressibility_factor(e))?;
    let pts = prof.points()?;
    for ((p, d), c) in pts.iter().zip(&dev).zip(cp.points()?).take(13) {
        println!(
            "   x={} n={} P/nTZ-1={}  Pchain/W-1={:.4}({:.4})",
            p.height,
            p.number_density,
            d.deviation,
            c.normal.mean / p.pressure.mean - 1.0,
            c.normal.standard_error / p.pressure.mean
        );
    }
    Ok(())
}
fn main() -> Result<(), Error> {
    let args: Vec<String> = std::env::args().collect();
    let w: f64 = args[1].parse().unwrap();
    let beta: f64 = args[2].parse().unwrap();
    let eq: u64 = args[3].parse().unwrap();
    let prod: u64 = args[4].parse().unwrap();
    let h = Hydrostatics::new(
        &UniformField::default(),
        &ExponentialTemperature::new(20.0, beta)?,
        &equation_of_state::FluidSolid::default(),
    )
    .lid(400.0)
    .column_density(40.0)?;
    println!("theory {}", h.center_of_mass());
    go("closure", w, beta, EquationOfStateClosure::default(), start::Theory, eq, prod)?;
    for b in [0.1, 0.5, 2.0] {
        go(
            &format!("self theory {b}"),
            w,
            beta,
            SelfConsistent::default().bin_width(b),
            start::Theory,
            eq,
            prod,
        )?;
    }
    go("self uniform 0.1", w, beta, SelfConsistent::default(), start::Uniform::default(), eq, prod)?;
    Ok(())
}
