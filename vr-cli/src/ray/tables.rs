//! Tables of the steps, or of the parts of the reference.

use vr_core::ProbedSample;
use vr_core::field::Cut;
use vr_physics::RaySegment;
use vr_study::ray::{CHANNELS, RayAccount, Row};

use super::figures;
use crate::table::Table;

/// Number of rows that are printed in any case.
const FEW: usize = 60;
/// Number of rows of a longer table: those that matter most.
const CHOSEN: usize = 40;

/// Returns the tables of the samples and their sums, or of the reference alone. A long table is shortened, unless `all` of it is asked for.
pub fn text(account: &RayAccount<'_>, all: bool) -> String {
    let count = if account.probe.is_some() { account.rows.len() } else { account.segments.len() };
    if count == 0 {
        return String::new();
    }
    let shown = if all || count <= FEW { (0..count).collect() } else { chosen(account, count) };
    let mut text = String::new();
    if shown.len() < count {
        text += &format!("\n{} of {count} rows, {}; --all prints all\n", shown.len(), why_chosen(account));
    }
    if account.probe.is_none() {
        return text + &format!("\n{}", parts(account, &shown));
    }
    text += &format!("\n{}", samples(account, &shown));
    text += &remarks(account);
    if account.has_light() {
        text += &format!("\n{}", sums(account, &shown));
    }
    text
}

/// Returns remarks on the table of the samples.
fn remarks(account: &RayAccount<'_>) -> String {
    let mut text = String::new();
    if account.rows.iter().any(|row| row.step.samples.iter().any(|sample| sample.value.is_nan())) {
        text += "-: vacuum\n";
    }
    if account.scene.transfer.has_rows() {
        text += "kappa is the largest of all rows by gradient, theta and light are those of the rows at the gradient\n";
    }
    if let Some(shading) = account.scene.shading.as_ref().filter(|_| account.has_light()) {
        if !account.scene.transfer.has_emission() {
            text += "colour and light are shaded\n";
        }
        if !shading.gradient_opacity.is_empty() {
            text += "kappa is without the gradient's factor, theta with it\n";
        }
    }
    text
}

/// Returns the rows of a long table that matter most, in order: where the error changes most, or the value is nearest to the picked one, or largest.
fn chosen(account: &RayAccount<'_>, count: usize) -> Vec<usize> {
    let picked = account.picked();
    let weight = |i: usize| match (account.rows.get(i), picked) {
        (Some(Row { light: Some(light), .. }), _) => light.change.abs(),
        (Some(_), Some(picked)) => -(i.abs_diff(picked) as f64),
        // Evenly: the bits of a number turned round.
        (Some(_), None) => -((i as u32).reverse_bits() as f64),
        (None, _) => account.segments[i].light.map_or(0.0, |light| {
            let in_front = if i > 0 { account.segments[i - 1].light.map_or(1.0, |l| 1.0 - l.opacity()) } else { 1.0 };
            in_front * (1.0 - light.transparency)
        }),
    };
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| weight(b).total_cmp(&weight(a)));
    order.truncate(CHOSEN);
    order.sort_unstable();
    order
}

fn why_chosen(account: &RayAccount<'_>) -> &'static str {
    match (account.probe.is_some(), account.has_light(), account.picked()) {
        (true, true, _) => "those in which the error changes most",
        (true, false, Some(_)) => "those next to what was picked",
        (true, false, None) => "evenly spread",
        (false, ..) => "those of which most is seen",
    }
}

/// Adds rows, with a word wherever some are left out.
fn fill(table: &mut Table, shown: &[usize], row: impl Fn(usize) -> Vec<String>) {
    let mut next = shown.first().copied().unwrap_or(0);
    for &i in shown {
        if i != next {
            table.row(["...".to_owned()]);
        }
        table.row(row(i));
        next = i + 1;
    }
}

fn samples(account: &RayAccount<'_>, shown: &[usize]) -> Table {
    let light = account.has_light();
    let gray =
        account.rows.iter().filter_map(|row| row.light).all(|l| l.color[0] == l.color[1] && l.color[1] == l.color[2]);
    let mut header = vec!["step", "begin", "length", "sample", "index x", "y", "z", "value"];
    if light {
        header.extend(["kappa", "colour", "theta", "light b"]);
    }
    let mut table = Table::new(&header);
    let picked = account.picked();
    fill(&mut table, shown, |i| {
        let row = &account.rows[i];
        let samples = &row.step.samples;
        let middle = &samples[samples.len() / 2];
        let [x, y, z] = middle.index.map(figures::short);
        let mark = if picked == Some(i) { " *" } else { "" };
        let mut cells = vec![
            format!("{}{mark}", row.number),
            figures::long(row.step.begin),
            figures::short(row.step.length),
            figures::long(middle.at),
            x,
            y,
            z,
            ends(samples.iter().map(|s: &ProbedSample| s.value)),
        ];
        if let Some(l) = row.light {
            cells.extend([
                ends(row.extinction.iter().copied()),
                figures::color(l.color, gray, figures::short),
                figures::short(row.step.transparency),
                figures::color(row.step.light, gray, figures::short),
            ]);
        }
        cells
    });
    table
}

/// Returns the first and the last of several.
fn ends(values: impl ExactSizeIterator<Item = f64> + DoubleEndedIterator) -> String {
    let several = values.len() > 1;
    let mut values = values.map(figures::short);
    let first = values.next().unwrap_or_default();
    if several { format!("{first}..{}", values.next_back().unwrap_or_default()) } else { first }
}

fn sums(account: &RayAccount<'_>, shown: &[usize]) -> Table {
    let c = account.channel();
    let gray = account
        .rows
        .iter()
        .filter_map(|row| row.light)
        .all(|l| [l.running, l.exact].iter().all(|sum| sum[0] == sum[1] && sum[1] == sum[2]));
    let error = format!("{} error", CHANNELS[c]);
    let header = [
        "step",
        "end",
        "radiance",
        "exact",
        "tau",
        "exact",
        error.as_str(),
        "change",
        "faces crossed",
        "knots crossed",
    ];
    let mut table = Table::new(&header);
    fill(&mut table, shown, |i| {
        let row = &account.rows[i];
        let Some(l) = row.light else { return Vec::new() };
        let rgb = |[r, g, b, _]: [f64; 4]| figures::color([r, g, b], gray, figures::short);
        vec![
            row.number.to_string(),
            figures::long(row.step.end()),
            rgb(l.running),
            rgb(l.exact),
            figures::short(l.depth),
            figures::short(l.exact_depth),
            figures::signed(l.error),
            figures::signed(l.change),
            figures::faces(&row.faces),
            figures::knots(&row.knots),
        ]
    });
    table
}

fn parts(account: &RayAccount<'_>, shown: &[usize]) -> Table {
    let mut header = vec!["part", "from", "length", "begins at", "value", "to"];
    if account.has_light() {
        header.extend(["theta", "light b", "radiance so far", "tau so far"]);
    }
    let mut table = Table::new(&header);
    fill(&mut table, shown, |i| {
        let part = &account.segments[i];
        let [first, last] = part.values.map(figures::short);
        let length = figures::short(part.to - part.from);
        let mut cells = vec![i.to_string(), figures::long(part.from), length, front(part), first, last];
        if let Some(l) = part.light {
            cells.extend([
                figures::short(l.transparency),
                figures::color(l.light, false, figures::short),
                figures::color(l.radiance, false, figures::short),
                figures::short(l.depth),
            ]);
        }
        cells
    });
    table
}

/// Lists the cuts of the ray at which a part begins.
pub fn front(part: &RaySegment) -> String {
    let name = |cut: &Cut| match *cut {
        Cut::Entry => Some("entry".to_owned()),
        Cut::Face { axis, at } => Some(figures::faces(&[(axis, at)])),
        Cut::Knot { value } => Some(format!("knot {}", figures::short(value))),
        Cut::Asked => None,
    };
    part.front.iter().filter_map(name).collect::<Vec<_>>().join(", ")
}
