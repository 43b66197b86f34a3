//! Printing that ignores a closed output.

/// The macro of the standard library, but errors are ignored instead of a panic: a run continues
/// when its output is closed, for example by `head`.
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
