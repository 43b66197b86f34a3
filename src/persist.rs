//! One line that makes a type of this library part of a checkpoint.

/// Implements [`Persist`](crate::checkpoint::Persist), if there are checkpoints, from the fields
/// that are to be kept, each with the method of [`Archive`](crate::checkpoint::Archive) for it:
/// `same` for what the user's own code has made and has to agree, `value`, `count` and `slice` for
/// numbers, `part` for what knows by itself what to keep. What follows the fields must hold of what
/// was read.
///
/// Fields that are left out are made by the constructor or filled anew after every sweep.
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
