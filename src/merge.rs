//! Merging the data of independent replicas of one scene.

use crate::{Error, Every};

/// Data that can be merged with those of an independent replica of the same scene.
///
/// Implemented by all [`observers`](crate::observers) of the library, by tuples of them, by
/// [`Every`], by `Vec`s of equal length, by [`BlockAverages`](crate::statistics::BlockAverages) and
/// by [`ForceBalance`](crate::drive::ForceBalance). The merged data are those of one observer that
/// sampled both runs, except that no block of the averages contains data of two replicas. Merge in
/// a fixed order (that of the replicas), because the last bits of sums depend on the order.
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
    /// Adds the data of `other`.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if slabs, bins, temperatures or sizes differ. A single observer
    /// is unchanged then. In a tuple or a `Vec`, those before the one that failed have been merged.
    fn merge(&mut self, other: &Self) -> Result<(), Error>;

    /// All `replicas` merged into one, in their order.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] if there are none; those of [`merge`](Self::merge).
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

/// `None` cannot be merged with `Some`.
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
