//! `Persist` for tuples and containers.

use super::{Archive, Persist};
use crate::{Error, Every};

impl Persist for () {
    fn persist(&mut self, _: &mut Archive<'_>) -> Result<(), Error> {
        Ok(())
    }
}

impl<P: Persist + ?Sized> Persist for &mut P {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        (**self).persist(archive)
    }
}

impl<P: Persist + ?Sized> Persist for Box<P> {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        (**self).persist(archive)
    }
}

/// It must be `Some` if it was `Some` in the checkpoint.
impl<P: Persist> Persist for Option<P> {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        archive.same("presence", &self.is_some())?;
        self.as_mut().map_or(Ok(()), |part| part.persist(archive))
    }
}

/// The number of elements must be that of the checkpoint.
impl<P: Persist> Persist for [P] {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        archive.same("number of parts", &self.len())?;
        self.iter_mut().try_for_each(|part| archive.part("part", part))
    }
}

/// The number of elements must be that of the checkpoint.
impl<P: Persist> Persist for Vec<P> {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        self.as_mut_slice().persist(archive)
    }
}

impl<P: Persist> Persist for Every<P> {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        archive.same("interval", &self.interval())?;
        archive.part("observer", &mut self.observer)
    }
}

macro_rules! persist_tuple {
    ($($name:ident $index:tt),+) => {
        impl<$($name: Persist),+> Persist for ($($name,)+) {
            fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
                $(archive.part(stringify!($index), &mut self.$index)?;)+
                Ok(())
            }
        }
    };
}
persist_tuple!(A 0);
persist_tuple!(A 0, B 1);
persist_tuple!(A 0, B 1, C 2);
persist_tuple!(A 0, B 1, C 2, D 3);
persist_tuple!(A 0, B 1, C 2, D 3, E 4);
persist_tuple!(A 0, B 1, C 2, D 3, E 4, F 5);
