use gradient_mc::{field::*, moves::*, start, temperature::*, *};
struct R(Vec<(usize, f64, f64, f64)>, Vec<(f64, Vector3<f64>)>);
impl Recorder for R {
    fn record_collision(&mut self, c: &Collision) {
        self.0.push((c.axis, c.from_height, c.to_height, c.separation));
    }
    fn record_move(&mut self, m: &AcceptedMove) {
        self.1.push((m.from_height, m.displacement));
    }
    fn record_chain(&mut self, _: usize, _: f64) {
        self.0.clear();
        self.1.clear();
    }
}
impl Observer for R {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}
fn main() -> Result<(), Error> {
    let slab = Slab::new(60.0, 10.0, 10.0)?;
    let scene = Scene::new(slab, 2414, UniformField::default(), Isothermal::new(4.0)?)?;
    for seed in 0..20 {
        let mut s = Simulation::builder(scene)
            .start(start::Compact)
            .seed(seed)
            .moves(EventChains::default())
            .build()?;
        let mut r = R(vec![], vec![]);
        if let Err(e) = s.equilibrate(100, &mut r) {
            println!("{e} events {} {:?}", r.0.len(), s.tally());
            for (c, m) in r.0[r.0.len() - 12..].iter().zip(&r.1[r.1.len() - 12..]) {
                println!("{c:?} {:?}", m.1.data.0);
            }
            let n = r.1.len();
            let zero = r.1.iter().filter(|m| m.1.norm() < 1e-9).count();
            println!("{n} moves {zero} of them below 1e-9");
            return Ok(());
        }
    }
    println!("fine");
    Ok(())
}
