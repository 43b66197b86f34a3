//! The page: pictures, captions and verdicts.

use super::Part;
use super::gather::{Gathered, Picture};
use paper::progress::in_words;
use paper::verdict::Verdict;
use std::fmt::Write as _;
use std::path::Path;

const STYLE: &str = "\
body { font: 16px/1.5 sans-serif; color: #222; max-width: 72rem; margin: 1rem auto; padding: 0 1rem; overflow-wrap: break-word }
h1, h2 { line-height: 1.2 }
h2 { margin-top: 3rem; border-top: 1px solid #ccc; padding-top: 1rem }
figure { margin: 2rem 0 0.5rem }
img { max-width: 100%; height: auto; border: 1px solid #ddd }
.wide { overflow-x: auto }
.verdict { margin: 0.3rem 0 }
summary { cursor: pointer; color: #444; font-size: 0.9rem }
figcaption { margin-top: 0.3rem }
table { border-collapse: collapse; font-size: 0.85rem; margin: 0.5rem 0 1rem }
td, th { text-align: left; padding: 0.15rem 0.8rem 0.15rem 0; vertical-align: top }
tr.fails td { background: #fbe3d6 }
.holds { color: #006b50 } .fails { color: #b03000; font-weight: bold }
pre { font-size: 0.75rem; overflow-x: auto; background: #f6f6f6; padding: 0.5rem }
code { background: #f6f6f6 }";

/// The page of these parts; `command` made it.
pub(crate) fn page(parts: &[Part], command: &str) -> String {
    let held: usize = parts.iter().map(|part| part.gathered.held()).sum();
    let claims: usize = parts.iter().map(|part| part.gathered.verdicts.len()).sum();
    let all = parts.iter().all(Part::holds);
    let mut html = String::new();
    let mut add = |text: &str| {
        html.push_str(text);
        html.push('\n');
    };
    add("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">");
    add("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">");
    add("<title>gradient-mc: the figures of the paper</title>");
    add(&format!("<style>\n{STYLE}\n</style>\n</head>\n<body>\n<h1>The figures of the paper</h1>"));
    add("<p>Mehrotra, Puri and Khakhar, Phys. Rev. E <b>83</b>, 061306 (2011), \
         <a href=\"https://doi.org/10.1103/PhysRevE.83.061306\">doi:10.1103/PhysRevE.83.061306</a>, from new simulations. \
         Lines are theory, points are simulation with one standard error. Every claim has a number and a range, and can fail.</p>");
    if command.ends_with("--short") {
        add("<p class=\"fails\">A short run to test the programs: its claims have no meaning.</p>");
    }
    let class = if all { "holds" } else { "fails" };
    add(&format!("<p><strong class=\"{class}\">{held} of {claims} claims hold.</strong></p>"));
    add(
        "<div class=\"wide\"><table>\n<tr><th>study</th><th>figures</th><th>claims that hold</th><th>how it ended</th></tr>",
    );
    for part in parts {
        let class = if part.holds() { "" } else { " class=\"fails\"" };
        add(&format!(
            "<tr{class}><td><a href=\"#{name}\">{name}</a></td><td>{}</td><td>{} of {}</td><td>{}</td></tr>",
            part.figures,
            part.gathered.held(),
            part.gathered.verdicts.len(),
            escape(&ending(part)),
            name = part.study,
        ));
    }
    add(&format!("</table></div>\n<p>Made by <code>{}</code>.</p>", escape(command)));
    for part in parts {
        add(&section(part));
    }
    add("</body>\n</html>");
    html
}

/// How the run of a study ended, in words.
fn ending(part: &Part) -> String {
    match &part.launched {
        None => "read from an earlier run".into(),
        Some(Err(failure)) => failure.to_string(),
        Some(Ok(launched)) => {
            let claims = if launched.holds { "" } else { "; a claim fails" };
            format!("finished in {}, building included{claims}", in_words(launched.duration))
        }
    }
}

fn section(part: &Part) -> String {
    let mut html = String::new();
    let Part { study, title, figures, directory, gathered, .. } = part;
    let _ = writeln!(html, "<h2 id=\"{study}\">{}: figures {figures}</h2>", escape(title));
    let _ = writeln!(html, "<p><code>cargo run --release -p paper --bin {study}</code></p>");
    if let Some(remark) = &gathered.remark {
        let _ = writeln!(html, "<p>{}</p>", escape(remark));
    }
    for missing in &gathered.missing {
        let _ = writeln!(html, "<p class=\"fails\">Missing: {}</p>", escape(missing));
    }
    let (with_picture, without) = gathered.by_picture();
    for (picture, verdicts) in with_picture {
        html.push_str(&figure(picture, directory, &verdicts));
        html.push_str(&table(&verdicts));
    }
    if !without.is_empty() {
        html.push_str("<h3>Other claims</h3>\n");
        html.push_str(&verdict_line(&without));
        html.push_str(&table(&without));
    }
    report(&mut html, gathered);
    html
}

fn report(html: &mut String, gathered: &Gathered) {
    if let Some(report) = &gathered.report {
        let _ = writeln!(
            html,
            "<details><summary>Output of the study</summary>\n<pre>{}</pre>\n</details>",
            escape(report)
        );
    }
}

/// The picture, one line of verdict and the caption. The picture leads to the drawing that can be
/// enlarged, and to its data where they have the same name.
fn figure(picture: &Picture, directory: &Path, verdicts: &[&Verdict]) -> String {
    let name = directory.file_name().unwrap_or_default().to_string_lossy();
    let stem = picture.file.trim_end_matches(".png");
    let link = |ending: &str| format!("../{name}/{stem}.{ending}");
    let exists = |ending: &str| directory.join(format!("{stem}.{ending}")).is_file();
    let image = format!(
        "<img src=\"{}\" alt=\"{}\" loading=\"lazy\">",
        escape(&link("png")),
        escape(&format!("{}: {}", picture.title(), picture.caption))
    );
    let image =
        if exists("svg") { format!("<a href=\"{}\">{image}</a>", escape(&link("svg"))) } else { image };
    let data = if exists("csv") {
        format!(" <a href=\"{}\">Data</a>.", escape(&link("csv")))
    } else {
        String::new()
    };
    let (title, caption) = (escape(&picture.title()), escape(&picture.caption));
    let verdict = verdict_line(verdicts);
    format!(
        "<figure>\n{image}\n{verdict}<figcaption><b>{title}.</b> {caption}{data}</figcaption>\n</figure>\n"
    )
}

/// Whether all of these claims hold, and how many do.
fn verdict_line(verdicts: &[&Verdict]) -> String {
    let held = verdicts.iter().filter(|verdict| verdict.holds()).count();
    let all = verdicts.len();
    match (all, held == all) {
        (0, _) => "<p class=\"verdict\">No claim.</p>\n".to_owned(),
        (1, true) => "<p class=\"verdict holds\">Holds: 1 claim.</p>\n".to_owned(),
        (_, true) => format!("<p class=\"verdict holds\">Holds: all {all} claims.</p>\n"),
        (_, false) => format!("<p class=\"verdict fails\">Fails: {held} of {all} claims hold.</p>\n"),
    }
}

/// Every claim, folded away.
fn table(verdicts: &[&Verdict]) -> String {
    if verdicts.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<details><summary>Claims</summary>\n<div class=\"wide\"><table>\n<tr><th></th><th>measured</th><th>must be</th><th>claim</th></tr>\n",
    );
    for verdict in verdicts {
        let word = if verdict.holds() { "holds" } else { "fails" };
        let _ = writeln!(
            html,
            "<tr class=\"{word}\"><td class=\"{word}\">{word}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&verdict.measured_in_words()),
            escape(&verdict.range()),
            escape(&verdict.claim)
        );
    }
    html.push_str("</table></div>\n</details>\n");
    html
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
