use gradient_mc::{field::*, moves::*, observers::*, start, temperature::*, *};
use std::time::Instant;
fn main() -> Result<(), Error> {
    let args: Vec<String> = std::env::args().collect();
    let w: f64 = args[1].parse().unwrap();
    let t: f64 = args[2].parse().unwrap();
    let length: f64 = args[3].parse().unwrap();
    let vf: f64 = args[4].parse().unwrap();
    let sweeps: u64 = args[5].parse().unwrap();
    let rev = args[6] == "rev";
    let n = (40.0 * w * w) as usize;
    let scene = Scene::new(Slab::new(400.0, w, w)?, n, UniformField::default(), Isothermal::new(t)?)?;
    let b = Simulation::builder(scene).start(start::Theory).seed(1);
    let b = if length > 0.0 {
        let mut c = EventChains::with_length(length)?.vertical_fraction(vf)?;
        if rev {
            c = c.field_event(FieldEvent::Reverse)
        };
        b.moves(c)
    } else {
        b
    };
    let mut s = b.build()?;
    let t0 = Instant::now();
    let mut last = 0.0;
    let mut cm = CenterOfMass::new();
    for k in 0..20 {
        cm = CenterOfMass::new();
        s.run(sweeps / 20, &mut cm)?;
        let h = cm.heights().iter().sum::<f64>() / cm.heights().len() as f64;
        println!(
            "{:2} t={:.2}s hc={:.3} events={:.3e} trials={:.2e} rate {:.3} M/s",
            k,
            t0.elapsed().as_secs_f64(),
            h,
            s.tally().events as f64,
            s.tally().trials as f64,
            (s.tally().events + s.tally().trials) as f64 / 1e6 / t0.elapsed().as_secs_f64()
        );
        last = h;
    }
    let _ = (last, cm);
    Ok(())
}
