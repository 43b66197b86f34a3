//! Warnings of several runs.

use gradient_mc::Warning;
use std::mem::discriminant;

/// One line for each kind of warning: the first warning of this kind, and the number of replicas
/// with it.
pub fn lines<'a>(replicas: impl IntoIterator<Item = &'a [Warning]>) -> Vec<String> {
    let replicas: Vec<&[Warning]> = replicas.into_iter().collect();
    let alike = |one: &Warning, other: &Warning| match (one, other) {
        (Warning::NotMixed { evidence, .. }, Warning::NotMixed { evidence: other, .. }) => {
            discriminant(evidence) == discriminant(other)
        }
        _ => one.kind() == other.kind(),
    };
    let mut kinds: Vec<(&Warning, usize)> = Vec::new();
    for warning in replicas.iter().flat_map(|warnings| warnings.iter()) {
        match kinds.iter_mut().find(|(first, _)| alike(first, warning)) {
            Some((_, count)) => *count += 1,
            None => kinds.push((warning, 1)),
        }
    }
    let runs = replicas.len();
    kinds
        .into_iter()
        .map(|(warning, count)| match runs {
            1 => format!("warning: {warning}"),
            _ => format!("warning ({count} of {runs} runs): {warning}"),
        })
        .collect()
}

/// Prints these lines, or that there are none.
pub fn print<'a>(replicas: impl IntoIterator<Item = &'a [Warning]>) {
    let lines = lines(replicas);
    if lines.is_empty() {
        println!("warnings: none");
    }
    for line in lines {
        println!("{line}");
    }
}
