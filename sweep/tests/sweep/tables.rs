//! Valid tables, and the position and reason of errors in invalid ones.

use gradient_mc::Replicas;
use gradient_mc_sweep::{BadTable, FieldChoice, Table, TemperatureChoice};

const GOOD: &str = r#"packing_fractions = [0.1, 0.2]

[[scene]]
name = "first"
height = 60.0
base = [5.0, 5]
spheres = 250
field.uniform = 1
temperature.isothermal = 5.0
seed = 1
replicas = 2
equilibration = 0
sweeps = 100

[[scene]]
name = "second"
height = 60.0
base = [5.0, 5.0]
spheres = 250
field = { exponential = 0.02 }
temperature.exponential = { base = 5.0, decay_rate = 0.02 }
seed = 2
replicas = 2
equilibration = 10
sweeps = 100
target_error = 0.1
"#;

/// What is said of the good table with a part replaced.
fn refused(part: &str, other: &str) -> BadTable {
    assert_eq!(GOOD.matches(part).count(), 1, "{part}");
    Table::read(&GOOD.replace(part, other)).unwrap_err()
}

#[test]
fn bad_tables_are_refused_with_line_and_column() {
    let second = |line: &str| format!("seed = 2\n{line}");
    let mut wrong = Vec::new();
    for (part, other, [line, column], message) in [
        // A field that does not exist, in each kind of table.
        ("seed = 2", &*second("sweps = 3"), [23, 1], "unknown field `sweps`"),
        ("packing_fractions", "packing_fraction", [1, 1], "unknown field `packing_fraction`"),
        ("decay_rate = 0.02", "decay = 0.02", [21, 41], "unexpected keys in table: decay"),
        ("exponential = 0.02", "quadratic = 0.02", [20, 11], "unknown variant `quadratic`"),
        // Numbers that are none, or senseless.
        ("isothermal = 5.0", "isothermal = nan", [9, 26], "NaN is not a finite number"),
        ("isothermal = 5.0", "isothermal = [5.0, inf]", [9, 32], "inf is not a finite number"),
        ("isothermal = 5.0", "isothermal = []", [9, 26], "an empty list"),
        ("isothermal = 5.0", "isothermal = -5.0", [9, 1], "temperature = -5"),
        ("isothermal = 5.0", "linear = { base = 5, slope = -0.1 }", [9, 1], "temperature is"),
        ("[0.1, 0.2]", "[0.1, nan]", [1, 27], "packing fraction of NaN"),
        ("[0.1, 0.2]", "[0.1, -0.2]", [1, 27], "packing fraction"),
        ("base = [5.0, 5]", "base = [5.0, 2.0]", [6, 8], "2"),
        ("base = [5.0, 5]", "base = [5.0]", [6, 8], "invalid length 1"),
        ("target_error = 0.1", "target_error = 0", [26, 16], "must be positive"),
        ("replicas = 2\nequilibration = 0", "replicas = 0\nequilibration = 0", [11, 12], "use 1 to"),
        ("equilibration = 0", "equilibration = -1", [12, 17], "-1"),
        ("spheres = 250\nfield.uniform", "spheres = 2500\nfield.uniform", [7, 11], "2500 spheres"),
        // Of another type.
        ("seed = 1", "seed = \"1\"", [10, 8], "invalid type: string"),
        ("seed = 1", "seed = 1.5", [10, 8], "invalid type: floating point"),
        ("uniform = 1", "uniform = true", [8, 17], "a number or a list of numbers"),
        // Twice.
        ("seed = 2", "seed = 1", [22, 8], "the seed 1 is that of scene \"first\""),
        ("\"second\"", "\"first\"", [16, 8], "the name \"first\" is used twice"),
        ("\"second\"", "\"../second\"", [16, 8], "is used in file names"),
        ("seed = 2", "seed = 2\nseed = 3", [23, 1], "duplicate key"),
        // Missing.
        ("sweeps = 100\ntarget", "target", [15, 1], "missing field `sweeps`"),
        (", decay_rate = 0.02", "", [21, 27], "missing field `decay_rate`"),
        ("temperature.isothermal = 5.0", "", [3, 1], "missing field `temperature`"),
        // No TOML at all.
        ("seed = 1", "seed = ", [10, 8], ""),
    ] {
        let error = refused(part, other);
        if !error.message.contains(message) || [error.line, error.column] != [line, column] {
            wrong.push(format!("{other}: {error}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    for (text, message) in [("", "missing field `scene`"), ("scene = []", "there is no scene")] {
        let error = Table::read(text).unwrap_err();
        assert!(error.line == 1 && error.message.contains(message), "{error}");
    }
}

#[test]
fn lists_stand_for_grids_whose_seeds_are_those_of_replicas() {
    let grid = GOOD
        .replace("uniform = 1\n", "linear = { base = [1.0, 2.0], slope = 0.0 }\n")
        .replace("isothermal = 5.0", "isothermal = [4.0, 5.0, 6.0]");
    let table = Table::read(&grid).unwrap();
    assert_eq!((table.cases.len(), table.tasks().len()), (7, 14));
    let case = &table.cases[4];
    assert_eq!(case.name, "first.4");
    assert_eq!(case.field, FieldChoice::Linear { base: 2.0, slope: 0.0 });
    assert_eq!(case.temperature, TemperatureChoice::Isothermal(5.0));
    let seeds = Replicas::new(2).seed(1).run_each(&[(); 6], |(), replica| Ok(replica.seed())).unwrap();
    assert_eq!([0, 1].map(|replica| case.replica(replica).seed()), seeds[4].replicas());
}

#[test]
fn the_table_of_the_documentation_is_good() {
    let table = Table::read(include_str!("../../scenes.toml")).unwrap();
    assert_eq!(table.cases.len(), 5);
}
