//! Pooling what independent replicas of one scene have seen.

use crate::{Error, Every};

/// Something that can take in what an independent replica of it has seen.
///
/// All ready [`observers`](crate::observers) can, and tuples of them, [`Every`] and `Vec`s of one
/// length; so can [`BlockAverages`](crate::statistics::BlockAverages) and
/// [`ForceBalance`](crate::drive::ForceBalance). What is merged is as if one observer had seen both
/// runs, but for errors: no block of the averages reaches over from one replica to the next. Merge
/// in a fixed order (that of the replicas), since sums of numbers depend on it in their last bits.
///
/// ```
/// use gradient_mc::observers::CenterOfMass;
/// use gradient_mc::{Error, Merge, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let run = |seed: u64| -> Result<CenterOfMass, Error> {
///     let mut center_of_mass = CenterOfMass::new();
///     Simulation::builder(scene).seed(seed).build()?.run(200, &mut center_of_mass)?;
///     Ok(center_of_mass)
/// };
/// let mut pooled = run(1)?;
/// pooled.merge(&run(2)?)?;
/// println!("{}", pooled.estimate()?);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
pub trait Merge {
    /// Takes in what `other` has seen.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the two do not belong together: other slabs, bins,
    /// temperatures or sizes. A single observer is unchanged then; of a tuple or a `Vec`, those
    /// before the one that failed have been merged.
    fn merge(&mut self, other: &Self) -> Result<(), Error>;

    /// All of several in one, merged in their order.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for none; those of [`merge`](Self::merge).
    fn pooled<'a>(replicas: impl IntoIterator<Item = &'a Self>) -> Result<Self, Error>
    where
        Self: Clone + 'a,
    {
        let mut replicas = replicas.into_iter();
        let first = replicas.next().ok_or(Error::TooFewObservations {
            what: "replicas to be merged",
            available: 0,
            needed: 1,
        })?;
        let mut pooled = first.clone();
        replicas.try_for_each(|replica| pooled.merge(replica))?;
        Ok(pooled)
    }
}

impl Merge for () {
    fn merge(&mut self, (): &Self) -> Result<(), Error> {
        Ok(())
    }
}

impl<M: Merge> Merge for Every<M> {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.observer.merge(&other.observer)
    }
}

/// One that is absent cannot be pooled with one that is there.
impl<M: Merge> Merge for Option<M> {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        match (self, other) {
            (Some(mine), Some(other)) => mine.merge(other),
            (None, None) => Ok(()),
            (_, other) => Err(Error::InvalidParameter {
                name: "number of observers to be pooled",
                value: f64::from(u8::from(other.is_some())),
                requirement: "both replicas must have one, or neither",
            }),
        }
    }
}

/// Element by element.
impl<M: Merge> Merge for Vec<M> {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        if self.len() != other.len() {
            return Err(Error::InvalidParameter {
                name: "number of observers to be pooled",
                value: other.len() as f64,
                requirement: "both replicas must have the same number",
            });
        }
        self.iter_mut().zip(other).try_for_each(|(mine, other)| mine.merge(other))
    }
}

macro_rules! merge_tuple {
    ($($name:ident $index:tt),+) => {
        impl<$($name: Merge),+> Merge for ($($name,)+) {
            fn merge(&mut self, other: &Self) -> Result<(), Error> {
                $(self.$index.merge(&other.$index)?;)+
                Ok(())
            }
        }
    };
}
merge_tuple!(A 0);
merge_tuple!(A 0, B 1);
merge_tuple!(A 0, B 1, C 2);
merge_tuple!(A 0, B 1, C 2, D 3);
merge_tuple!(A 0, B 1, C 2, D 3, E 4);
merge_tuple!(A 0, B 1, C 2, D 3, E 4, F 5);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::BlockAverages;

    fn averages(components: usize, observations: usize) -> BlockAverages {
        let mut averages = BlockAverages::new(components).unwrap();
        for _ in 0..observations {
            averages.push(&vec![1.0; components]).unwrap();
        }
        averages
    }

    #[test]
    fn collections_are_merged_part_by_part() {
        let mut mine =
            (averages(1, 2), Every::new(3, averages(2, 3)), Some(averages(1, 1)), vec![averages(3, 1)]);
        let other =
            (averages(1, 5), Every::new(3, averages(2, 7)), Some(averages(1, 1)), vec![averages(3, 4)]);
        mine.merge(&other).unwrap();
        let observed = [&mine.0, &mine.1.observer, mine.2.as_ref().unwrap(), &mine.3[0]];
        assert_eq!(observed.map(BlockAverages::observations), [7, 10, 2, 5]);
        let mut absent: Option<BlockAverages> = None;
        absent.merge(&None).unwrap();
        assert!(matches!(absent.merge(&Some(averages(1, 1))), Err(Error::InvalidParameter { .. })));
        assert!(matches!(mine.2.merge(&None), Err(Error::InvalidParameter { .. })));
        assert!(matches!(mine.3.merge(&Vec::new()), Err(Error::InvalidParameter { .. })));
    }

    #[test]
    fn a_single_one_that_fails_is_unchanged_and_a_tuple_stops_there() {
        let mut mine = (averages(1, 2), averages(2, 2));
        let before = mine.1.clone();
        assert!(mine.merge(&(averages(1, 1), averages(3, 1))).is_err());
        assert_eq!(mine.1, before);
        assert_eq!(mine.0.observations(), 3);
    }
}
