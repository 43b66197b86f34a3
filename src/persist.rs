//! The macro that makes a type of this library part of a checkpoint.

/// Implements [`Persist`](crate::checkpoint::Persist), with the feature `checkpoint`, from a list
/// of fields. Each field has a method of [`Archive`](crate::checkpoint::Archive): `same` for values
/// that the program has set and that must be equal in the checkpoint; `value`, `count` and `slice`
/// for numbers; `part` for fields that implement `Persist`. A condition after the fields is checked
/// after reading.
///
/// Fields that are not listed are set by the constructor, or overwritten after every sweep.
macro_rules! persist {
    ($type:ty { $($kind:ident $field:ident),* $(,)? }) => {
        persist!($type { $($kind $field),* }, |_| true);
    };
    ($type:ty { $($kind:ident $field:ident),* $(,)? }, |$this:pat_param| $holds:expr) => {
        #[cfg(feature = "checkpoint")]
        impl $crate::checkpoint::Persist for $type {
            fn persist(&mut self, archive: &mut $crate::checkpoint::Archive<'_>) -> Result<(), $crate::Error> {
                $(archive.$kind(stringify!($field), &mut self.$field)?;)*
                let $this = &*self;
                archive.check($holds)
            }
        }
    };
}
