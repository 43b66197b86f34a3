//! Measures the messages between ranks that share one column: a prototype of the messages, not of
//! the physics.
//!
//! ```sh
//! cargo build --release -p gradient-mc-sweep --features mpi --examples --bins
//! mpirun -n 2 target/release/examples/ghosts
//! ```
//!
//! The base of a column is cut into one strip for each rank. After every sweep of local moves a
//! rank sends the spheres within one diameter of the cuts to its neighbors, as in a real shared
//! simulation. The received spheres are only counted: each strip is periodic and simulated
//! independently, so the work of a rank is realistic.
//!
//! The model is `latency + bytes / bandwidth` for the messages in each direction, with both
//! parameters measured at the start by messages of other sizes. The shortest of many times is used,
//! because other programs may use the cores.

use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Scene, Simulation, Slab};
use mpi::point_to_point::traits::{Destination as _, Source as _};
use mpi::topology::{Communicator, SimpleCommunicator};
use mpi::traits::CommunicatorCollectives as _;
use std::time::Instant;

/// Spheres per area, as in the paper.
const COLUMN_DENSITY: f64 = 40.0;
const HEIGHT: f64 = 400.0;
const TEMPERATURE: f64 = 20.0;
/// Spheres within this distance of a cut are sent, in diameters.
const REACH: f64 = 1.0;
/// Bytes of a sphere: three numbers of eight bytes.
const BYTES: f64 = 24.0;
const SWEEPS: usize = 15;

/// The ranks in a ring, and buffers for received messages.
struct Ring {
    world: SimpleCommunicator,
    room: [Vec<f64>; 2],
}

impl Ring {
    /// Seconds for one exchange: all ranks send to the next and to the previous rank.
    fn seconds(&mut self, up: &[f64], down: &[f64]) -> f64 {
        let Self { world, room: [from_before, from_next] } = self;
        let (rank, ranks) = (world.rank(), world.size());
        let next = world.process_at_rank((rank + 1) % ranks);
        let before = world.process_at_rank((rank + ranks - 1) % ranks);
        world.barrier();
        let start = Instant::now();
        mpi::request::scope(|scope| {
            let sent =
                [next.immediate_send_with_tag(scope, up, 1), before.immediate_send_with_tag(scope, down, 2)];
            before.receive_into_with_tag(&mut from_before[..], 1);
            next.receive_into_with_tag(&mut from_next[..], 2);
            for request in sent {
                request.wait();
            }
        });
        start.elapsed().as_secs_f64()
    }

    /// The shortest of many times.
    fn shortest(&mut self, up: &[f64], down: &[f64], times: usize) -> f64 {
        (0..times).map(|_| self.seconds(up, down)).fold(f64::INFINITY, f64::min)
    }
}

/// Largest resident memory of this process so far, in bytes; NaN if the system does not report it.
fn memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    kibibytes.map_or(f64::NAN, |kibibytes| 1024.0 * kibibytes)
}

/// CPU time of this process.
fn cpu_seconds() -> f64 {
    // Clock ticks of 1/100 s, after the name in brackets.
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<f64>() / 100.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let largest: f64 = std::env::args().nth(1).map_or(Ok(1e6), |text| text.parse())?;
    let universe = mpi::initialize().ok_or("MPI cannot be initialized")?;
    let world = universe.world();
    let (rank, ranks) = (u64::try_from(world.rank())?, f64::from(world.size()));
    let is_first = rank == 0;
    // Twice the size needed by the widest strip.
    let mut ring = Ring { world, room: [vec![0.0; 400_000], vec![0.0; 400_000]] };
    let many = vec![0.5; 400_000];
    let latency = ring.shortest(&[], &[], 500);
    let bandwidth = 8.0 * many.len() as f64 / (ring.shortest(&many, &many, 500) - latency);
    if is_first {
        println!(
            "{ranks} ranks; two messages each way at once: latency {:.1} us, bandwidth {:.2} GB/s each way\n",
            1e6 * latency,
            1e-9 * bandwidth
        );
        println!("spheres     base      bytes sent / sweep        ms / exchange      ns / trial   share of");
        println!(
            "/ rank      width     measured      model    measured    model    (CPU)        a sweep    bytes / sphere"
        );
    }
    for spheres in [1e4, 1e5, 1e6, 1e7].into_iter().filter(|&spheres| spheres <= largest) {
        // The whole base is square.
        let width = (spheres * ranks / COLUMN_DENSITY).sqrt();
        let strip = width / ranks;
        let slab = Slab::new(HEIGHT, strip, width)?;
        let scene = Scene::with_column_density(
            slab,
            COLUMN_DENSITY,
            UniformField::default(),
            Isothermal::new(TEMPERATURE)?,
        )?;
        let mut simulation =
            Simulation::builder(scene).moves(LocalMoves::new(0.5)?).seed(1 + rank).build()?;
        // The lattice of the start melts.
        simulation.equilibrate(if spheres < 1e6 { 100 } else { 5 }, &mut ())?;
        let (mut exchange_time, mut bytes, mut busy) = (f64::INFINITY, 0.0, 0.0);
        for _ in 0..SWEEPS {
            let start = cpu_seconds();
            simulation.run(1, &mut ())?;
            busy += cpu_seconds() - start;
            let (mut up, mut down) = (Vec::new(), Vec::new());
            for position in simulation.frame().positions() {
                if position.y < REACH {
                    down.extend([position.x, position.y, position.z]);
                }
                if position.y > strip - REACH {
                    up.extend([position.x, position.y, position.z]);
                }
            }
            exchange_time = ring.shortest(&up, &down, 20).min(exchange_time);
            bytes += 8.0 * (up.len() + down.len()) as f64 / SWEEPS as f64;
        }
        let model_bytes = 2.0 * REACH * width * COLUMN_DENSITY * BYTES;
        let model = latency + 0.5 * model_bytes / bandwidth;
        let sweep = busy / SWEEPS as f64;
        if is_first {
            println!(
                "{spheres:<8.0} {width:>7.0} {:>13.0} {model_bytes:>10.0} {:>11.3} {:>8.3} {:>9.0} {:>13.4} % {:>11.0}",
                bytes,
                1e3 * exchange_time,
                1e3 * model,
                1e9 * sweep / scene.particles() as f64,
                100.0 * exchange_time / sweep,
                memory() / scene.particles() as f64,
            );
        }
    }
    Ok(())
}
