//! Printing that goes on when nobody reads.

/// As that of the standard library, but what cannot be written is lost, where that panics: a run
/// that writes files goes on when `head` has seen enough, or when its terminal is gone.
#[macro_export]
macro_rules! println {
    ($($what:tt)*) => {
        $crate::print_line(&mut std::io::stdout(), format_args!($($what)*))
    };
}

/// See [`println`](crate::println).
#[macro_export]
macro_rules! eprintln {
    ($($what:tt)*) => {
        $crate::print_line(&mut std::io::stderr(), format_args!($($what)*))
    };
}

/// Of [`println`](crate::println).
#[doc(hidden)]
pub fn print_line(to: &mut dyn std::io::Write, line: std::fmt::Arguments<'_>) {
    writeln!(to, "{line}").ok();
}
