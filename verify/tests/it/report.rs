//! The report on made-up evidence with everything in it that can go wrong. The page is left in the target's `tmp/report` for a
//! look.

use std::collections::HashSet;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use verify::evidence::{
    Axis, Cell, Check, Evidence, Field, Figure, Grid, Mark, Outcome, Panel, Requirement, Section, Series, Spread, Table,
};
use verify::report::{self, Chapter, ComparisonError, Earlier, Run};

const NASTY: &str = "<script>alert(\"1\" & '2')</script> ]]> `a < b` | \u{1}\u{7} λ→∞ 𝓛 \\ *x* ${y}";

fn check(id: &str, outcome: Outcome, measured: Option<f64>) -> Check {
    Check {
        id: id.into(),
        statement: format!("The order of `{id}` on the damped pendulum is 2"),
        outcome,
        measured,
        required: Some(Requirement::Near(2.0, 0.05)),
        reason: if outcome == Outcome::Pass {
            String::new()
        } else {
            "slope over 6 of 9 points; 3 at the floor".into()
        },
    }
}

fn log_axis(label: &str) -> Axis {
    Axis { label: label.into(), log: true, limits: None }
}

fn linear_axis(label: &str) -> Axis {
    Axis { label: label.into(), log: false, limits: None }
}

fn series(label: &str, mark: Mark, points: impl IntoIterator<Item = (f64, f64)>) -> Series {
    Series { label: label.into(), points: points.into_iter().collect(), mark }
}

fn order_panel(title: &str, floor: f64) -> Panel {
    let steps = || (0..12).map(|k| 0.5f64.powi(k));
    let methods = [
        ("Method I", 2),
        ("Method II", 2),
        ("implicit Euler", 1),
        ("RK4", 4),
        ("trapezoidal rule", 2),
        ("implicit midpoint", 2),
        ("SDIRK2", 2),
        ("BDF2", 2),
        ("p_n = 0", 2),
    ];
    let curves = methods.iter().enumerate().map(|(index, (method, order))| {
        let constant = 0.4 / (index + 1) as f64;
        series(method, Mark::LineMarkers, steps().map(move |h| (h, (constant * h.powi(*order)).max(floor))))
    });
    let guides = [
        series("slope 2", Mark::Guide, steps().map(|h| (h, 0.8 * h * h))),
        series("slope 4", Mark::Guide, steps().map(|h| (h, 0.2 * h.powi(4)))),
    ];
    Panel {
        title: title.into(),
        x: log_axis("h / s"),
        y: log_axis("max |error|"),
        series: curves.chain(guides).collect(),
        field: None,
    }
}

fn stability_panel() -> Panel {
    let x: Vec<f64> = (0..81).map(|i| -8.0 + 0.15 * f64::from(i)).collect();
    let y: Vec<f64> = (0..81).map(|j| -6.0 + 0.15 * f64::from(j)).collect();
    // |R(z)| of Method I for normal systems, z = x + iy.
    let amplification = |x: f64, y: f64| (1.0 + y * y).sqrt() / (1.0 - x + 0.5 * (x * x + y * y)).abs();
    let mut values: Vec<Vec<_>> = y.iter().map(|&b| x.iter().map(|&a| amplification(a, b)).collect()).collect();
    // A pole in the dark region and a hole in the white one.
    (values[40][3], values[40][60]) = (f64::INFINITY, f64::NAN);
    Panel {
        title: "Method I, |R(z)|".into(),
        x: linear_axis("Re z"),
        y: linear_axis("Im z"),
        series: vec![series("imaginary axis", Mark::Guide, [(0.0, -6.0), (0.0, 6.0)])],
        field: Some(Field {
            x,
            y,
            values,
            levels: vec![0.1, 0.3, 1.0],
            bands: ["|R| < 0.1", "0.1 to 0.3", "0.3 to 1", "|R| ≥ 1"].map(Into::into).to_vec(),
            contours: true,
        }),
    }
}

fn basin_panel() -> Panel {
    let x: Vec<f64> = (0..41).map(|i| 10f64.powf(-2.0 + 0.1 * f64::from(i))).collect();
    let y: Vec<f64> = (0..31).map(|j| 0.1 * f64::from(j)).collect();
    let class = |product: f64| match product {
        p if p > 20.0 => f64::NAN,
        p if p > 2.0 => 2.0,
        _ => 0.0,
    };
    let values = y.iter().map(|&v| x.iter().map(|&h| class(h * v)).collect()).collect();
    Panel {
        title: "Basin of the right root".into(),
        x: log_axis("h / s"),
        y: linear_axis("v₀"),
        series: vec![series("h v₀ = 2", Mark::Line, x.iter().map(|h| (*h, 2.0 / h)))],
        field: Some(Field {
            x,
            y,
            values,
            levels: vec![0.5, 1.5],
            bands: ["right root", "lost branch", "spurious root"].map(Into::into).to_vec(),
            contours: false,
        }),
    }
}

fn odd_panels() -> Vec<Panel> {
    let trap = |title: &str, x: Axis, y: Axis, label: &str, mark: Mark, points: &[(f64, f64)]| Panel {
        title: title.into(),
        x,
        y,
        series: vec![series(label, mark, points.iter().copied())],
        field: None,
    };
    let (log, linear) = (|| log_axis("h"), || linear_axis("t"));
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let bad = [(0.0, 1.0), (-1.0, 2.0), (1e-3, nan), (1e-2, inf), (0.1, 1e-12), (1.0, 0.0), (10.0, 3e-12)];
    let far = [(0.0, 1e-9), (1.0, 1e9), (2.0, 1e100)];
    let decay = (0..200).map(|i| 0.05 * f64::from(i)).map(|t| (t, (-t).exp()));
    let growth = (0..11).map(|n| (f64::from(n), (-1.3f64).powi(n)));
    let wave = (0..50_000).map(|i| 2e-4 * f64::from(i)).map(|t| (t, (100.0 * t).sin()));
    vec![
        trap("Zeros, NaN and ∞ on log axes", log(), log(), "bad", Mark::LineMarkers, &bad),
        trap("One point", log(), log(), "one", Mark::Markers, &[(0.1, 3e-100)]),
        trap("No points", linear(), linear(), "none", Mark::Line, &[]),
        trap("A constant, by a line", linear(), linear(), "constant", Mark::Line, &[(0.0, 1.0), (1.0, 1.0)]),
        Panel { title: "A map alone".into(), series: Vec::new(), y: linear(), ..basin_panel() },
        trap(NASTY, linear_axis(NASTY), log_axis(NASTY), NASTY, Mark::Line, &far),
        Panel {
            x: Axis { limits: Some((0.0, 10.0)), ..linear_axis("t / s") },
            y: Axis { limits: Some((-1.5, 1.5)), ..linear_axis("v(t)") },
            series: vec![
                series("exp(−t)", Mark::Guide, decay),
                series("grows", Mark::LineMarkers, growth),
                series("long", Mark::Line, wave),
            ],
            ..Panel::default()
        },
    ]
}

fn table(id: &str, columns: &[&str], rows: Vec<Vec<Cell>>, shown: bool) -> Table {
    Table {
        id: id.into(),
        caption: format!("Errors of `{id}` at the paper's steps."),
        columns: columns.iter().map(|name| (*name).into()).collect(),
        rows,
        shown,
    }
}

fn text(text: &str) -> Cell {
    Cell::Text(text.into())
}

fn linear_drag() -> Chapter {
    let numbers = [0.1, -1e-6, 1.0 / 3.0, f64::INFINITY, 2.0, 5e-324, f64::MAX, 123456.789];
    let row = |(n, value): (usize, &f64)| {
        let status = if value.is_finite() { "ok" } else { NASTY };
        vec![
            text("damped-pendulum"),
            Cell::Number(*value),
            text("linear(-1,1)"),
            Cell::Integer(n as i64 - 3),
            text(status),
        ]
    };
    let mut rows: Vec<_> = numbers.iter().enumerate().map(row).collect();
    let lost = text("lost its branch at t = 1.25");
    rows.push(vec![text("quadratic-drag"), Cell::Empty, text("method-ii"), Cell::Empty, lost]);
    let errors = table("figure-2", &["problem", "max_error", "method", "steps", "status"], rows, true);
    let note = "Method I overtakes RK4 at `h = 1.54`; below that RK4 is ahead by several orders of magnitude.";
    Chapter {
        seconds: 0.0,
        id: "linear-drag".into(),
        title: "Linear drag".into(),
        question: "Do the closures reproduce their closed forms, and how large is the error at the paper's steps?"
            .into(),
        source: "[S24] §4, Figs 1–2".into(),
        evidence: Evidence {
            timings: vec![("a run".into(), 0.5)],
            spreads: vec![Spread {
                what: NASTY.into(),
                solver: "rk4".into(),
                base: "bdf2".into(),
                ratios: [0.9, 1.0, 1.4],
            }],
            checks: vec![check("closed-form", Outcome::Pass, Some(3.3e-16)), check("cvode", Outcome::NotRun, None)],
            tables: vec![errors, table("empty", &["h"], Vec::new(), true)],
            figures: vec![
                figure("figure-2", 2, vec![order_panel("Linear drag", 1e-16), order_panel("Damped pendulum", 1e-13)]),
                figure("stability", 2, vec![stability_panel(), basin_panel()]),
            ],
            grids: vec![grid()],
            notes: vec![note.into()],
            sections: vec![Section {
                id: "S00-a".into(),
                title: "The figure has a place of its own".into(),
                mark: "confirmed".into(),
                paragraphs: vec![("Evidence".into(), "A slope of 2 at `h < 1`.".into())],
                figures: vec!["stability".into()],
                tables: vec!["empty".into()],
            }],
        },
        error: None,
    }
}

fn grid() -> Grid {
    let mut grid = Grid::new("map", "Log of the difference over its bound.", 1);
    grid.push("method-i", NASTY, Some(-2.04), Some(0.0), "closed-form");
    grid.push("rk4", "heat", None, Some(0.0), "cvode");
    grid
}

fn figure(id: &str, columns: usize, panels: Vec<Panel>) -> Figure {
    Figure {
        id: id.into(),
        caption: "Maximum error against the step. The curves follow the guide `slope 2` until roundoff.".into(),
        data: "figure-2".into(),
        panels,
        columns,
    }
}

fn orders() -> Chapter {
    let passed = (0..20).map(|n| check(&format!("order/method-{n}"), Outcome::Pass, Some(2.0 + 1e-3 * f64::from(n))));
    let mut checks: Vec<_> = passed.collect();
    checks.push(check("order/linear(-1, 1)/van-der-pol", Outcome::Fail, Some(1.0423)));
    checks.push(check("order/bdf2", Outcome::Inconclusive, Some(f64::NAN)));
    let many = (0..60).map(|n| vec![Cell::Integer(n), Cell::Number(0.1f64.powi(n as i32))]).collect();
    Chapter {
        id: "orders".into(),
        title: "Orders of accuracy".into(),
        question: "Is every method of the order that it claims?".into(),
        evidence: Evidence {
            checks,
            tables: vec![
                table("series", &["n", "value"], many, true),
                table("loose", &["n"], vec![vec![Cell::Integer(1)]; 3], false),
            ],
            figures: vec![figure("odd", 3, odd_panels())],
            ..Evidence::default()
        },
        ..Chapter::default()
    }
}

fn nasty() -> Chapter {
    Chapter {
        seconds: 0.0,
        id: "nasty".into(),
        title: NASTY.into(),
        question: NASTY.into(),
        source: NASTY.into(),
        evidence: Evidence {
            checks: vec![Check {
                id: NASTY.into(),
                statement: NASTY.into(),
                outcome: Outcome::Fail,
                measured: Some(f64::INFINITY),
                required: None,
                reason: format!("{NASTY} {}", "long".repeat(200)),
            }],
            tables: vec![table("figure 3/../x", &[NASTY], vec![vec![text(NASTY)]], true)],
            notes: vec![NASTY.into()],
            sections: vec![Section {
                id: "odd <b>".into(),
                title: NASTY.into(),
                mark: NASTY.into(),
                paragraphs: vec![(NASTY.into(), NASTY.into())],
                ..Section::default()
            }],
            ..Evidence::default()
        },
        error: Some(format!("diverged at t = 3\nwith {NASTY}")),
    }
}

fn synthetic() -> Run {
    let provenance = [("lsvi", "0.1.0"), ("SUNDIALS", "6.4.1"), ("parameters", NASTY)];
    let provenance = provenance.map(|(key, value)| (key.into(), value.into())).to_vec();
    Run::new(vec![linear_drag(), orders(), nasty()], provenance)
}

/// A path of its own for each test, with nothing there.
pub(super) fn fresh(name: &str) -> PathBuf {
    crate::scratch(&format!("report/{name}"))
}

fn written(name: &str) -> PathBuf {
    let path = fresh(name);
    report::write(&synthetic(), &path).expect("the report is written");
    path
}

pub(super) fn read(path: &Path, name: &str) -> String {
    unpacked(&fs::read_to_string(path.join(name)).expect("a file of the report"))
}

/// The page with its folded parts as they are once opened.
fn unpacked(page: &str) -> String {
    const OPENING: &str = "<script class=\"packed\" type=\"text/plain\">";
    let mut parts = page.split(OPENING);
    let mut whole = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (packed, rest) = part.split_once("</script>").expect("it is closed");
        let bytes = BASE64_STANDARD.decode(packed).expect("base 64");
        flate2::read::ZlibDecoder::new(bytes.as_slice()).read_to_string(&mut whole).expect("zlib");
        whole.push_str(rest);
    }
    whole
}

struct Tag {
    name: String,
    attributes: Vec<(String, String)>,
    closes: bool,
    is_empty: bool,
}

/// The tags in order; panics on stray brackets, unquoted attributes, unescaped ampersands and control characters.
fn tags(markup: &str) -> Vec<Tag> {
    let mut tags = Vec::new();
    let mut rest = markup;
    while let Some((before, tail)) = rest.split_once('<') {
        assert!(!before.contains('>'), "stray > in {before:?}");
        assert_escaped(before);
        rest = tail;
        if let Some(comment) = rest.strip_prefix("!--") {
            rest = comment.split_once("-->").expect("a closed comment").1;
            continue;
        }
        if rest.starts_with(['!', '?']) {
            rest = rest.split_once('>').expect("a closed declaration").1;
            continue;
        }
        let closes = rest.starts_with('/');
        rest = rest.trim_start_matches('/');
        let end = rest.find(|c: char| c.is_whitespace() || c == '>' || c == '/').expect("a tag's end");
        let name = rest[..end].to_owned();
        assert!(name.chars().all(|c| c.is_ascii_alphanumeric()), "odd tag {name:?}");
        rest = &rest[end..];
        let mut attributes = Vec::new();
        let is_empty = loop {
            rest = rest.trim_start();
            if let Some(tail) = rest.strip_prefix("/>") {
                rest = tail;
                break true;
            }
            if let Some(tail) = rest.strip_prefix('>') {
                rest = tail;
                break false;
            }
            let (key, tail) = rest.split_once("=\"").expect("a quoted attribute");
            assert!(key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-'), "odd attribute {key:?}");
            let (value, tail) = tail.split_once('"').expect("a closed quote");
            assert!(!value.contains('<'), "< in {value:?}");
            assert_escaped(value);
            attributes.push((key.to_owned(), unescape(value)));
            rest = tail;
        };
        let is_raw = !closes && ["script", "style"].contains(&name.as_str());
        if is_raw {
            rest = &rest[rest.find(&format!("</{name}>")).expect("a closed script or style")..];
        }
        tags.push(Tag { name, attributes, closes, is_empty });
    }
    tags
}

fn assert_escaped(text: &str) {
    for tail in text.split('&').skip(1) {
        let name = tail.split_once(';').expect("an entity's end").0;
        assert!(["amp", "lt", "gt", "quot", "apos", "#39"].contains(&name), "unescaped & before {tail:?}");
    }
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "control character in {text:?}");
}

fn unescape(text: &str) -> String {
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
    text.replace("&#39;", "'").replace("&apos;", "'").replace("&amp;", "&")
}

fn assert_balanced(tags: &[Tag], void: &[&str]) {
    let mut open = Vec::new();
    for tag in tags {
        if tag.closes {
            assert_eq!(open.pop(), Some(&tag.name), "closes what is not open; open: {open:?}");
        } else if !tag.is_empty && !void.contains(&tag.name.as_str()) {
            open.push(&tag.name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

#[test]
fn the_page_is_well_formed_and_its_links_lead_somewhere() {
    let path = written("report");
    let html = read(&path, "index.html");
    let tags = tags(&html);
    assert_balanced(&tags, &["meta", "link", "br"]);
    let attributes: Vec<_> = tags.iter().flat_map(|tag| &tag.attributes).collect();
    let values = |key: &str| -> Vec<&str> {
        attributes.iter().filter(|(name, _)| name == key).map(|(_, value)| value.as_str()).collect()
    };
    let ids: HashSet<_> = values("id").into_iter().collect();
    assert_eq!(ids.len(), values("id").len(), "repeated ids");
    assert!(ids.iter().all(|id| !id.is_empty() && !id.contains(char::is_whitespace)));
    let links = values("href");
    for link in &links {
        match link.strip_prefix('#') {
            Some(anchor) => assert!(ids.contains(anchor), "#{anchor} leads nowhere"),
            None => assert!(link.starts_with("data:") || path.join(link).is_file(), "no file {link}"),
        }
    }
    for reference in values("aria-labelledby").into_iter().flat_map(str::split_whitespace) {
        assert!(ids.contains(reference), "labelled by {reference}, which is not there");
    }
    for reference in html.split("url(#").skip(1).map(|tail| tail.split(')').next().unwrap_or_default()) {
        assert!(ids.contains(reference), "clipped by {reference}, which is not there");
    }
    for anchor in ["linear-drag", "linear-drag/closed-form", "table:figure-2", "figure:figure-2", "report/numbers"] {
        assert!(ids.contains(anchor), "no anchor {anchor}");
    }
    for file in ["data/figure-2.csv", "data/loose.csv", "results.json", "junit.xml", "report.md"] {
        assert!(links.contains(&file), "no link to {file}");
    }
    // Namespaces are names, not addresses.
    let addresses = html.replace("http://www.w3.org/", "");
    assert!(!addresses.contains("http:") && !addresses.contains("https:"), "the page asks the network");
}

#[test]
fn a_keyboard_reaches_all_that_a_mouse_does() {
    let tags = tags(&read(&written("keyboard"), "index.html"));
    let opened: Vec<_> = tags.iter().filter(|tag| !tag.closes).collect();
    for (tag, next) in opened.iter().zip(opened.iter().skip(1)) {
        let of = |key: &str| tag.attributes.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str());
        assert!(tag.attributes.iter().all(|(key, _)| !key.starts_with("on")), "a handler on {}", tag.name);
        assert!(tag.name != "a" || of("href").is_some(), "a link without an address is not reached");
        assert!(tag.name != "details" || next.name == "summary", "a fold without a summary");
        let scrolls = of("class").is_some_and(|class| class.split(' ').any(|name| name == "scroll"));
        assert_eq!(scrolls, of("tabindex") == Some("0"), "what scrolls takes the focus, and nothing else but controls");
        assert!(!scrolls || of("aria-label").or(of("aria-labelledby")).is_some(), "what takes the focus has a name");
    }
}

/// A third row is not a third column.
#[test]
fn the_style_says_whether_it_counts_cells_or_rows() {
    let page = read(&written("style"), "index.html");
    let (_, style) = page.split_once("<style>").expect("a style");
    let (style, _) = style.split_once("</style>").expect("its end");
    let before: Vec<&str> = style.split(":nth-child(").collect();
    assert!(before.len() > 3);
    for selector in &before[..before.len() - 1] {
        assert!(["td", "th", ":is(th, td)", " tr"].iter().any(|of| selector.ends_with(of)), "{selector}:nth-child(");
    }
}

/// A difference that theory predicts passes, and is neither green nor red.
#[test]
fn a_map_explains_its_cells_and_sets_predicted_differences_apart() {
    let mut map = grid();
    map.push("astray", "heat", Some(8.0), None, "closed-form");
    map.push("broke-down", "heat", None, None, "closed-form");
    let chapter = linear_drag();
    let evidence = Evidence { grids: vec![map], ..chapter.evidence };
    let path = fresh("map");
    report::write(&Run::new(vec![Chapter { evidence, ..chapter }], Vec::new()), &path).expect("written");
    let page = read(&path, "index.html");
    let cell =
        |class: &str, text: &str| format!("<td class=\"{class}\"><a href=\"#linear-drag/closed-form\">{text}</a>");
    for part in [cell("p0", "−2.0"), cell("predicted", "+8.0"), cell("predicted", "≠")] {
        assert!(page.contains(&part), "{part}");
    }
    let (_, key) = page.split_once("<ul class=\"key\">").expect("a key");
    let (key, _) = key.split_once("</ul>").expect("its end");
    for (said, text) in [(true, "as predicted"), (true, "not run"), (true, "holds"), (false, "not decided")] {
        assert_eq!(key.contains(text), said, "{text} in {key}");
    }
}

/// What a reader sees, without code: no number as a programming language prints it, and no key of a file as a head.
#[test]
fn numbers_and_heads_read_as_a_person_would_write_them() {
    let reason = "order 3.898 ± 2.2e-2, ends at a step of 1.0000e0, t = 1.000e1, `1e-6` is code";
    let checks = vec![Check { reason: reason.into(), ..check("c", Outcome::Fail, Some(1e-12)) }];
    let keys = ["h_1_64", "at_re", "t_end", "method_ii", "r_infinity", "problem"];
    let rows = vec![vec![Cell::Number(1e-9), text("below 1e-8"), text("a"), text("b"), Cell::Number(0.0), text("c")]];
    let evidence = Evidence { checks, tables: vec![table("keys", &keys, rows, true)], ..Evidence::default() };
    let path = fresh("people");
    report::write(&Run::new(vec![Chapter { id: "p".into(), evidence, ..Chapter::default() }], Vec::new()), &path)
        .expect("written");
    let page = read(&path, "index.html");
    let (_, body) = page.split_once("<main>").expect("the page");
    let (body, _) = body.split_once("</main>").expect("its end");
    let seen: String =
        body.split("<code>").map(|part| part.split_once("</code>").map_or(part, |(_, rest)| rest)).collect();
    let seen: String =
        seen.split('<').map(|part| part.split_once('>').map_or(part, |(_, text)| text)).collect::<Vec<_>>().join(" ");
    let bytes = seen.as_bytes();
    for (place, _) in seen.match_indices('e') {
        let digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        let signed = bytes.get(place + 1).is_some_and(|b| b"+-".contains(b)) && digit(place + 2);
        let is_raw = place > 0 && digit(place - 1) && (digit(place + 1) || signed);
        assert!(!is_raw, "{}", &seen[place.saturating_sub(20)..place + 4]);
    }
    for (said, text) in [(true, "± 0.022"), (true, "step of 1,"), (true, "t = 10,"), (true, "below 10⁻⁸")] {
        assert_eq!(seen.contains(text), said, "{text} in {seen}");
    }
    for head in ["h = 1/64", "Re hλ", "end t", "Method II", "R(∞)", "problem"] {
        assert!(seen.contains(head), "{head}");
    }
    assert!(keys[..5].iter().all(|key| !seen.contains(key) && !seen.contains(&key.replace('_', " "))), "{seen}");
}

/// Who asks about a model of his own finds what to take before the notes and the words.
#[test]
fn the_recommendation_for_a_model_comes_first_and_the_words_are_folded() {
    let told = Section {
        id: "model-recommendation".into(),
        title: "Which method to use".into(),
        paragraphs: vec![("Answer".into(), "Take `rk4`.".into())],
        figures: vec!["work".into()],
        ..Section::default()
    };
    let figures = vec![figure("work", 1, vec![order_panel("Work", 1e-16)])];
    let evidence = Evidence { notes: vec!["A note.".into()], sections: vec![told], figures, ..Evidence::default() };
    let model = Chapter { id: "model".into(), evidence, ..Chapter::default() };
    let path = fresh("model-first");
    report::write(&Run::new(vec![model.clone()], Vec::new()), &path).expect("written");
    let alone = read(&path, "index.html");
    let place = |page: &str, text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
    assert!(place(&alone, "Which method to use") < place(&alone, "A note."));
    assert!(alone.contains("<details><summary>Terms"));
    let (opening, rest) = alone.split_once("id=\"_summary\"").expect("the counts");
    assert!(opening.contains("Take <code>rk4</code>.") && opening.contains("href=\"#_answers\">Skip"));
    assert!(place(rest, "Take <code>rk4</code>.") < place(rest, "figure:work"), "before the pictures that show why");
    // Beside the answers of the whole report the words stand open.
    let answers = Chapter { id: "answers".into(), ..Chapter::default() };
    report::write(&Run::new(vec![answers, model], Vec::new()), &path).expect("written");
    assert!(!read(&path, "index.html").contains("<details><summary>Terms"));
}

/// Words, figures and tables that belong together stand under one heading, on the page and in Markdown.
#[test]
fn running_text_has_headings_in_sight_and_its_evidence_below_them() {
    let found = |name: &str| Evidence {
        notes: vec![format!("All about {name} with `verify {name}`.")],
        tables: vec![table(name, &["h"], vec![vec![Cell::Number(0.25)]], true)],
        figures: vec![Figure { data: name.into(), ..figure(name, 1, vec![order_panel(name, 1e-16)]) }],
        checks: vec![check(name, Outcome::Pass, Some(2.0))],
        ..Evidence::default()
    };
    let mut evidence = Evidence::default();
    for name in ["gains", "losses"] {
        evidence.add_under((format!("told-{name}"), &format!("Where it {name}")), found(name));
    }
    let path = fresh("running-text");
    let chapter = Chapter { id: "told".into(), evidence, ..Chapter::default() };
    report::write(&Run::new(vec![chapter], Vec::new()), &path).expect("written");
    let page = read(&path, "index.html");
    let (_, page) = page.split_once("<section class=\"chapter\" id=\"told\">").expect("the chapter");
    let order = [
        "<h3>Where it gains",
        "<p>All about gains with <code>verify gains</code>.</p>",
        "<summary>1 figure, 1 table</summary>",
        "figure:gains",
        "table:gains",
        "<h3>Where it losses",
        "<p>All about losses",
        "figure:losses",
        "table:losses",
        "<summary>2 checks that passed</summary>",
        "told/gains",
    ];
    let mut rest = page;
    for text in order {
        let Some((_, after)) = rest.split_once(text) else { panic!("{text} is not in its place:\n{page}") };
        rest = after;
    }
    assert_eq!(page.matches("id=\"figure:gains\"").count(), 1);
    assert_eq!(page.matches("id=\"table:gains\"").count(), 1);
    let markdown = read(&path, "report.md");
    let order = ["#### Where it gains\n\nAll about gains", "Errors of `gains`", "#### Where it losses", "| | Check |"];
    let places = order.map(|text| markdown.find(text).unwrap_or_else(|| panic!("{text}:\n{markdown}")));
    assert!(places.is_sorted(), "{places:?}\n{markdown}");
    assert_eq!(markdown.matches("Errors of `gains`").count(), 1);
}

#[test]
fn a_chapter_of_checks_alone_takes_one_click() {
    let evidence = Evidence { checks: vec![check("c", Outcome::Pass, Some(2.0))], ..Evidence::default() };
    let path = fresh("one-click");
    let chapter = Chapter { id: "alone".into(), evidence, ..Chapter::default() };
    report::write(&Run::new(vec![chapter], Vec::new()), &path).expect("written");
    let page = read(&path, "index.html");
    let (_, chapter) = page.split_once("<section class=\"chapter\" id=\"alone\">").expect("the chapter");
    let (chapter, _) = chapter.split_once("</section>").expect("its end");
    assert_eq!(chapter.matches("<details").count(), 1, "{chapter}");
    assert!(chapter.contains("1 check that passed") && chapter.contains("alone/c"));
}

/// What did not pass is on the first page and in the text for a pull request, whichever way it did not.
#[test]
fn checks_of_every_outcome_but_one_are_told() {
    let outcomes = [
        (Outcome::Pass, "passed"),
        (Outcome::Fail, "failed"),
        (Outcome::Inconclusive, "inconclusive"),
        (Outcome::NotSettled, "unsettled"),
        (Outcome::NotRun, "absent"),
    ];
    let checks =
        outcomes.map(|(outcome, id)| Check { statement: format!("The {id} one"), ..check(id, outcome, Some(2.0)) });
    let chapter = Chapter {
        id: "all".into(),
        evidence: Evidence { checks: checks.into(), ..Evidence::default() },
        ..Chapter::default()
    };
    let path = fresh("outcomes");
    report::write(&Run::new(vec![chapter], Vec::new()), &path).expect("written");
    let page = read(&path, "index.html");
    let start = page.find("id=\"_summary\"").expect("a summary");
    let summary = &page[start..page[start..].find("id=\"all\"").map_or(page.len(), |end| start + end)];
    let text = read(&path, "report.md");
    // Under a heading with their number.
    let open: String =
        text.split("\n## ").filter(|part| part.lines().next().is_some_and(|line| line.ends_with("(1)"))).collect();
    for (outcome, id) in outcomes {
        let is_open = outcome != Outcome::Pass;
        assert_eq!(summary.contains(&format!("The {id} one")), is_open, "{id} on the first page");
        assert_eq!(open.contains(&format!("The {id} one")), is_open, "{id} in {text}");
    }
}

/// Version, commit and date; how the claims came out, before how the checks did; and a way past all that for the keyboard.
#[test]
fn the_first_screen_says_what_it_is_and_counts_the_verdicts() {
    let claim = |place: usize, mark: &str| Section { id: format!("S{place}"), mark: mark.into(), ..Section::default() };
    let marks = ["confirmed", "refuted as stated", "confirmed", "open"];
    let sections = marks.iter().enumerate().map(|(place, mark)| claim(place, mark)).collect();
    let claims = Chapter {
        id: "claims".into(),
        evidence: Evidence { sections, checks: vec![check("c", Outcome::Pass, Some(2.0))], ..Evidence::default() },
        ..Chapter::default()
    };
    let provenance = [("verify", "0.1.0"), ("commit", "abc123"), ("date", "2026-11-22"), ("target", "x")];
    let provenance = provenance.map(|(key, value)| (key.into(), value.into())).to_vec();
    let path = fresh("first-screen");
    report::write(&Run::new(vec![claims], provenance), &path).expect("written");
    let page = read(&path, "index.html");
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
    assert!(page.contains("verify 0.1.0 · commit abc123 · date 2026-11-22"));
    let order = [
        "href=\"#_summary\">Skip",
        "<h1>",
        "4 claims of the papers",
        "<b>2</b> <span>confirmed",
        "<b>1</b> <span>refuted as stated",
        "<b>1</b> <span>open",
        " checks</p>",
    ];
    let places: Vec<usize> = order.iter().map(|text| place(text)).collect();
    assert!(places.is_sorted(), "{places:?}");
    assert!(!page.contains("<b>0</b> <span>qualified"), "what is no verdict of any claim has no tile");
}

/// In a real browser, if there is one: a map is one stop, and the arrow keys go over blank cells.
#[test]
fn arrow_keys_go_from_cell_to_cell_of_a_map() {
    let mut map = Grid::new("keys", "Keys.", 1);
    // A blank in the middle of the first row.
    for (row, column) in [("a", "x"), ("b", "y"), ("b", "z"), ("a", "z")] {
        map.push(row, column, Some(0.0), Some(0.0), format!("{row}{column}"));
    }
    let checks = ["ax", "by", "bz", "az"].map(|id| check(id, Outcome::Pass, Some(2.0))).to_vec();
    let evidence = Evidence { grids: vec![map], checks, ..Evidence::default() };
    let path = fresh("arrows");
    let chapter = Chapter { id: "m".into(), evidence, ..Chapter::default() };
    report::write(&Run::new(vec![chapter], Vec::new()), &path).expect("written");
    let file = path.join("index.html");
    let press = "<script>const stops = document.querySelectorAll('table.grid a[tabindex=\"0\"]');
        stops[0].focus(); const seen = [stops.length];
        for (const key of ['ArrowRight', 'ArrowDown', 'ArrowLeft', 'ArrowLeft', 'ArrowUp']) {
          document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
          seen.push(document.activeElement.hash);
        }
        document.title = seen.join(' ');</script>";
    fs::write(&file, format!("{}{press}", fs::read_to_string(&file).expect("the page"))).expect("writable");
    let Some((page, said)) = browsed(&path, "") else { return };
    assert!(said.is_empty(), "{said:#?}");
    let (_, title) = page.split_once("<title>").expect("a title");
    assert!(title.starts_with("1 #m/az #m/bz #m/by #m/by #m/by<"), "{}", &title[..80]);
}

#[test]
fn figures_are_numbered_in_the_order_of_the_page() {
    let told = Section { id: "model-recommendation".into(), figures: vec!["told".into()], ..Section::default() };
    let figures = ["behind", "told"].map(|id| figure(id, 1, vec![order_panel(id, 1e-16)])).to_vec();
    let evidence = Evidence { figures, sections: vec![told], ..Evidence::default() };
    let path = fresh("numbered");
    report::write(&Run::new(vec![Chapter { id: "model".into(), evidence, ..Chapter::default() }], Vec::new()), &path)
        .expect("the report is written");
    let page = read(&path, "index.html");
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
    assert!(place("figure:told") < place("Figure 1.") && place("Figure 1.") < place("figure:behind"));
    assert!(place("figure:behind") < place("Figure 2."));
}

#[test]
fn the_page_opens_with_each_question_its_answer_and_one_sentence() {
    let paragraphs = [("Answer", "It is slow."), ("Short", "`rk4` is faster.")]
        .map(|(label, text)| (label.into(), text.into()))
        .to_vec();
    let asked = Section {
        id: "answer-x".into(),
        title: "Is x fast?".into(),
        mark: "no".into(),
        paragraphs,
        ..Section::default()
    };
    let evidence = Evidence { sections: vec![asked], ..Evidence::default() };
    let path = fresh("opening");
    report::write(&Run::new(vec![Chapter { id: "answers".into(), evidence, ..Chapter::default() }], Vec::new()), &path)
        .expect("the report is written");
    let page = read(&path, "index.html");
    let (opening, _) = page.split_once("id=\"_summary\"").expect("the counts");
    for part in ["href=\"#answer-x\">Is x fast?</a>", ">no</span>", "<code>rk4</code> is faster."] {
        assert!(opening.contains(part), "{part} in {opening}");
    }
    assert!(!opening.contains("It is slow."), "the rest stands in the chapter");
    assert_eq!(page.matches("is faster").count(), 1, "and the sentence does not");
}

#[test]
fn figures_say_what_they_leave_out_and_draw_only_numbers() {
    let html = read(&written("figures"), "index.html");
    // Two of the seven bad points have a place on logarithmic axes.
    assert!(html.contains("Without 5 points"));
    assert_eq!(html.matches("Nothing to draw").count(), 1);
    let shapes = ["d", "x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "width", "height", "points"];
    for (key, value) in tags(&html).iter().flat_map(|tag| &tag.attributes) {
        let is_shape = shapes.contains(&key.as_str());
        assert!(!is_shape || !(value.contains("NaN") || value.contains("inf")), "{key}={value:?}");
    }
    // A series of fifty thousand points must not become as many vertices.
    assert!(html.len() < 500_000, "{} bytes", html.len());
}

#[test]
fn junit_counts_what_it_lists() {
    let xml = read(&written("junit"), "junit.xml");
    let tags = tags(&xml);
    assert_balanced(&tags, &[]);
    let opened = |name: &str| tags.iter().filter(|tag| tag.name == name && !tag.closes).count();
    let root = tags.iter().find(|tag| tag.name == "testsuites").expect("a root");
    let declared = |key: &str| {
        let count = root.attributes.iter().find(|(name, _)| name == key).expect("a count");
        count.1.parse::<usize>().expect("a number")
    };
    let listed = [opened("testcase"), opened("failure"), opened("error"), opened("skipped")];
    assert_eq!(["tests", "failures", "errors", "skipped"].map(declared), listed);
    // Two made-up failures and the odd table name that the audit finds.
    assert_eq!(listed[1..], [3, 1, 2]);
    assert_eq!(opened("testsuite"), 4);
}

#[test]
fn tables_read_back_from_csv() {
    let path = written("csv");
    let run = synthetic();
    let table = &run.chapters()[0].evidence.tables[0];
    let mut reader = csv::Reader::from_path(path.join("data/figure-2.csv")).expect("the file");
    assert_eq!(reader.headers().expect("a header").iter().collect::<Vec<_>>(), table.columns);
    let records: Vec<_> = reader.records().map(|record| record.expect("a record")).collect();
    assert_eq!(records.len(), table.rows.len());
    for (record, row) in records.iter().zip(&table.rows) {
        assert_eq!(record.len(), row.len());
        for (field, cell) in record.iter().zip(row) {
            match cell {
                Cell::Text(text) => assert_eq!(field, text),
                Cell::Number(value) => assert_eq!(field.parse().map(f64::to_bits), Ok(value.to_bits()), "{field}"),
                Cell::Integer(value) => assert_eq!(field.parse(), Ok(*value)),
                Cell::Empty => assert_eq!(field, ""),
            }
        }
    }
    assert!(path.join("data/figure~20~3~2f~..~2f~x.csv").is_file(), "an odd identifier stays within data/");
}

#[test]
fn results_hold_every_check_and_no_silent_null() {
    let text = read(&written("json"), "results.json");
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let counts = synthetic().counts();
    assert_eq!(value["schema"], 2);
    assert_eq!(value["counts"]["fail"], counts.fail);
    let chapters = value["chapters"].as_array().expect("chapters");
    let checks: usize = chapters.iter().map(|chapter| chapter["checks"].as_array().map_or(0, Vec::len)).sum();
    assert_eq!(checks, counts.checks());
    assert_eq!(chapters[1]["checks"][21]["measured"], "NaN");
    assert_eq!(chapters[1]["checks"][20]["outcome"], "fail");
    let rows = &chapters[0]["tables"][0]["rows"];
    assert_eq!(rows[3][1], "inf");
    assert_eq!(rows[5][1].as_f64(), Some(5e-324));
    assert!(rows[8][1].is_null());
    assert!(chapters[1]["tables"][1]["rows"].is_null(), "data behind a figure stand in their file");
    let run = synthetic();
    let mut hidden = 0;
    for (chapter, written) in run.chapters().iter().zip(chapters) {
        for (table, written) in chapter.evidence.tables.iter().zip(written["tables"].as_array().expect("tables")) {
            assert_eq!(written["row_count"], table.rows.len(), "{}", table.id);
            assert_eq!(written["rows"].is_null(), !table.shown, "{}", table.id);
            hidden += usize::from(!table.shown && !table.rows.is_empty());
        }
    }
    assert!(hidden > 0);
}

/// Within one table, every row has as many cells as the header.
fn assert_rectangular(markdown: &str) {
    let mut header = None;
    for line in markdown.lines() {
        let cells = line.replace("\\|", "").matches('|').count();
        if line.starts_with('|') {
            assert_eq!(*header.get_or_insert(cells), cells, "{line}");
        } else {
            header = None;
        }
    }
}

#[test]
fn markdown_fits_a_comment_and_escapes_its_tables() {
    let markdown = read(&written("markdown"), "report.md");
    assert!(markdown.len() < 65_536, "{} bytes", markdown.len());
    assert!(!markdown.contains("<script>"));
    assert_eq!(markdown.matches("<details>").count(), markdown.matches("</details>").count());
    let failures = markdown.find("## Fail (3)").expect("the failures");
    assert!(failures < markdown.find("## Details").expect("the details"));
    assert_rectangular(&markdown);
}

fn very_long() -> Run {
    let chapter = |n: u32| {
        let checks = (0..100).map(|m| check(&format!("c{m}"), Outcome::Fail, Some(1.0))).collect();
        let evidence = Evidence { checks, ..Evidence::default() };
        Chapter { id: format!("long-{n}"), title: "Long".into(), evidence, ..Chapter::default() }
    };
    Run::new((0..30).map(chapter).collect(), Vec::new())
}

#[test]
fn markdown_of_a_very_long_run_is_cut() {
    let path = fresh("cut");
    report::write(&very_long(), &path).expect("the report is written");
    let markdown = read(&path, "report.md");
    assert!(markdown.len() < 65_536, "{} bytes", markdown.len());
    assert!(markdown.contains("more, see `index.html`"));
}

#[test]
fn the_summary_fits_a_terminal() {
    for run in [synthetic(), very_long(), Run::new(Vec::new(), Vec::new())] {
        let plain = report::summary(&run, false);
        assert!(plain.lines().all(|line| line.chars().count() <= 80), "{plain}");
        assert!(plain.lines().count() <= 24, "{plain}");
        assert!(!plain.contains(|c: char| c.is_control() && c != '\n'), "{plain:?}");
    }
    assert!(report::summary(&synthetic(), true).contains("\u{1b}[31m"));
}

#[test]
fn the_audit_finds_what_it_looks_for() {
    let ragged = table("t", &["a", "b"], vec![vec![Cell::Number(f64::NAN)]], true);
    let mut short_map = stability_panel();
    short_map.field.as_mut().expect("a map").values[3].pop();
    let chapter = Chapter {
        id: "report".into(),
        evidence: Evidence {
            checks: vec![check("c", Outcome::Pass, None), check("c", Outcome::Pass, None)],
            tables: vec![ragged.clone(), Table { id: "a/b".into(), ..ragged }],
            figures: vec![Figure { data: "nowhere".into(), ..figure("f", 2, vec![stability_panel(), short_map]) }],
            grids: vec![Grid::new("whole", "", 1), grid()],
            sections: vec![Section { id: "s".into(), tables: vec!["lost".into()], ..Section::default() }],
            ..Evidence::default()
        },
        ..Chapter::default()
    };
    let run = Run::new(vec![chapter], Vec::new());
    let failed: Vec<_> = run.checks_that(Outcome::Fail).map(|(chapter, check)| (&*chapter.id, &*check.id)).collect();
    assert_eq!(
        failed,
        ["unique-ids", "plain-ids", "rectangular", "numbers", "data", "maps", "parts"].map(|id| ("report", id))
    );
    assert_eq!(run.chapters()[0].id, "report-2", "the audit keeps its name");
    let rectangular = &run.chapters()[1].evidence.checks[2];
    assert_eq!(rectangular.reason, "1 in `t`; 1 in `a/b`; a map in figure `f`");
    assert_eq!(run.chapters()[1].evidence.checks[8].reason, "`closed-form`; `cvode`");
    report::write(&run, &fresh("audit")).expect("defects do not stop the report");
    assert_eq!(run.chapters()[0].evidence.checks[1].id, "c-2");
    assert!(!run.counts().is_ok());
    assert!(Run::new(Vec::new(), Vec::new()).counts().is_ok());
}

#[test]
fn a_second_run_replaces_the_first_and_touches_nothing_else() {
    let path = written("replace");
    let html = read(&path, "index.html");
    fs::write(path.join("data/mine.csv"), "kept").expect("a file of the user's");
    report::write(&synthetic(), &path).expect("the report is written");
    assert_eq!(read(&path, "index.html"), html, "the output is deterministic");
    report::write(&Run::new(Vec::new(), Vec::new()), &path).expect("the report is written");
    let names = |path: &Path| {
        let entries = fs::read_dir(path).expect("a directory").map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<_> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    assert_eq!(names(&path), ["data", "index.html", "junit.xml", "report.md", "results.json", "timings.json"]);
    assert_eq!(names(&path.join("data")), ["mine.csv"]);
}

#[test]
fn what_cannot_be_written_is_named() {
    let path = fresh("unwritable");
    fs::create_dir_all(&path).expect("a directory");
    fs::write(path.join("data"), "a file in the way").expect("a file");
    let error = report::write(&synthetic(), &path).expect_err("data is a file");
    assert!(error.to_string().contains("data"), "{error}");
    assert_eq!(fs::read_dir(&path).expect("a directory").count(), 1, "nothing half-written is left");
}

/// A chapter of checks (id, outcome, measured, required), and of claims with their verdicts.
fn dated(checks: &[(&str, Outcome, f64, Option<Requirement>)], claims: &[(&str, &str)]) -> Run {
    let checks = checks
        .iter()
        .map(|(id, outcome, measured, required)| Check { required: *required, ..check(id, *outcome, Some(*measured)) });
    let rows = claims.iter().map(|(id, verdict)| vec![Cell::Text((*id).into()), Cell::Text((*verdict).into())]);
    let evidence = Evidence {
        checks: checks.collect(),
        tables: vec![table("claims", &["id", "verdict"], rows.collect(), true)],
        ..Evidence::default()
    };
    Run::new(vec![Chapter { id: "audit".into(), title: "Audit".into(), evidence, ..Chapter::default() }], Vec::new())
}

#[test]
fn a_comparison_shows_what_changed_and_nothing_else() {
    use Outcome::{Fail, Pass};
    use Requirement::{AtMost, Near};
    let path = fresh("compare-old");
    let old = dated(
        &[
            ("same", Pass, 1e-16, Some(AtMost(1e-12))),
            ("within", Pass, 2.001, Some(Near(2.0, 0.1))),
            ("beyond", Pass, 2.0, Some(Near(2.0, 0.1))),
            ("unbounded", Pass, 100.0, None),
            ("nan", Fail, f64::NAN, Some(AtMost(1.0))),
            ("broken", Pass, 0.5, Some(AtMost(1.0))),
            ("tightened", Pass, 0.5, Some(AtMost(1.0))),
            ("moved", Pass, 0.5, Some(AtMost(1.0))),
            ("dropped", Pass, 0.5, Some(AtMost(1.0))),
            ("loosened", Fail, 1.5, Some(AtMost(1.0))),
            ("lost", Pass, 0.5, Some(AtMost(1.0))),
        ],
        &[("S24-a", "confirmed"), ("S24-b", "qualified"), ("S24-c", "open")],
    );
    report::write(&old, &path).expect("the report is written");
    let earlier = Earlier::read(&path.join("results.json")).expect("of this program");

    let summary = report::summary(&old.clone().compared_with(&earlier), false);
    assert!(summary.contains("nothing changed since"), "{summary}");

    // A file of the time when requirements were sentences.
    let text = read(&path, "results.json").replace("\"schema\": 2", "\"schema\": 1");
    let mut value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    for check in value["chapters"][0]["checks"].as_array_mut().expect("checks") {
        check["required"] = "≤ 1.000e0".into();
    }
    let sentences = path.join("schema-1.json");
    fs::write(&sentences, value.to_string()).expect("writable");
    let summary = report::summary(&old.clone().compared_with(&Earlier::read(&sentences).expect("read still")), false);
    assert!(summary.contains("nothing changed since"), "{summary}");

    let new = dated(
        &[
            ("tightened", Pass, 0.5, Some(AtMost(0.6))),
            ("fresh", Pass, 0.0, Some(AtMost(1.0))),
            ("same", Pass, 9e-16, Some(AtMost(1e-12))),
            ("within", Pass, 2.0109, Some(Near(2.0, 0.1))),
            ("beyond", Pass, 2.0111, Some(Near(2.0, 0.1))),
            ("unbounded", Pass, 111.0, None),
            ("nan", Fail, f64::NAN, Some(AtMost(1.0))),
            ("broken", Fail, 1.5, Some(AtMost(1.0))),
            ("moved", Pass, 0.9, Some(AtMost(2.0))),
            ("dropped", Pass, 0.5, None),
            ("loosened", Pass, 1.5, Some(AtMost(2.0))),
        ],
        &[("S24-a", "confirmed"), ("S24-b", "refuted"), ("S24-d", "open")],
    )
    .compared_with(&earlier);
    let path = fresh("compare-new");
    report::write(&new, &path).expect("the report is written");
    let markdown = read(&path, "report.md");
    let (_, changes) = markdown.split_once("## Compared: ").expect("a section");
    let changes: Vec<_> = changes.lines().filter_map(|line| line.strip_prefix("- **audit: ")).collect();
    assert_eq!(
        changes,
        [
            "S24-b** · verdict qualified → refuted",
            "S24-d** · new verdict: open",
            "S24-c** · verdict gone, it was open",
            "tightened** · required ≤ 1 → ≤ 0.6",
            "fresh** · new: pass",
            "beyond** · measured 2 → 2.011, required 2 ± 0.1",
            "unbounded** · measured 100 → 111, required nothing",
            "broken** · pass → fail",
            "moved** · measured 0.5 → 0.9, required ≤ 2",
            "moved** · required ≤ 1 → ≤ 2",
            "dropped** · required ≤ 1 → nothing",
            "loosened** · fail → pass",
            "loosened** · required ≤ 1 → ≤ 2",
            "lost** · gone, it was pass",
        ]
    );
    let summary = report::summary(&new, false);
    assert!(
        summary.contains("14 changes since") && summary.lines().all(|line| line.chars().count() <= 80),
        "{summary}"
    );

    // A study that was left out this time has not lost its checks.
    let other = Run::new(Vec::new(), Vec::new()).compared_with(&earlier);
    let summary = report::summary(&other, false);
    assert!(summary.contains("nothing changed") && summary.contains("not in this run: audit"), "{summary}");
}

#[test]
fn a_comparison_tells_which_study_breaks_off_and_which_no_longer_does() {
    let with = |error: Option<&str>| {
        let chapter = Chapter { id: "audit".into(), error: error.map(str::to_owned), ..Chapter::default() };
        Run::new(vec![chapter], Vec::new())
    };
    let cases = [
        (Some("no luck"), None, vec!["no longer breaks off"]),
        (None, Some("no luck"), vec!["breaks off: no luck"]),
        (Some("no luck"), Some("none again"), vec![]),
        (None, None, vec![]),
    ];
    for (was, is, told) in cases {
        let path = fresh("compare-broken");
        report::write(&with(was), &path).expect("the report is written");
        let earlier = Earlier::read(&path.join("results.json")).expect("of this program");
        report::write(&with(is).compared_with(&earlier), &path).expect("the report is written");
        let markdown = read(&path, "report.md");
        let changes: Vec<_> = markdown.lines().filter_map(|line| line.strip_prefix("- **audit** · ")).collect();
        assert_eq!(changes, told, "{markdown}");
    }
}

#[test]
fn seconds_and_their_spreads_are_those_of_the_run() {
    let spread = Spread { what: "a".into(), solver: "b".into(), base: "c".into(), ratios: [1.25, 1.5, 2.75] };
    let timings = vec![("a run".to_owned(), 0.75)];
    let evidence = Evidence { spreads: vec![spread], timings, ..Evidence::default() };
    let chapter = Chapter { id: "peers".into(), seconds: 2.5, evidence, ..Chapter::default() };
    let path = fresh("times");
    report::write(&Run::new(vec![chapter], Vec::new()), &path).expect("the report is written");
    let times: serde_json::Value = serde_json::from_str(&read(&path, "timings.json")).expect("JSON");
    let times = &times["chapters"][0];
    assert_eq!((&times["id"], times["seconds"].as_f64()), (&"peers".into(), Some(2.5)));
    assert_eq!(times["runs"], serde_json::json!({ "a run": 0.75 }));
    // From the least to the median, in the order of the head.
    let page = unpacked(&read(&path, "index.html"));
    let (_, table) = page.split_once("aria-label=\"Times\"").expect("the table");
    let (head, rows) = table.split_once("</thead>").expect("a head");
    let names: Vec<_> = head.split("<th scope=\"col\">").skip(1).filter_map(|rest| rest.split('<').next()).collect();
    let cells = |rest: &str| rest.split_once('>').and_then(|(_, text)| text.split('<').next().map(str::to_owned));
    let (row, _) = rows.split_once("</tr>").expect("a row");
    let row: Vec<_> = row.split("<td").skip(1).filter_map(cells).collect();
    let pairs: Vec<_> = names.into_iter().zip(row.iter().map(String::as_str)).collect();
    let expected =
        [("problem", "a"), ("solver", "b"), ("least", "1.25"), ("quartile", "1.50"), ("median", "2.75"), ("base", "c")];
    assert_eq!(pairs, expected);
}

#[test]
fn what_is_no_earlier_report_is_refused() {
    let path = fresh("compare-bad");
    fs::create_dir_all(&path).expect("writable");
    let file = path.join("old.json");
    assert!(matches!(Earlier::read(&file), Err(ComparisonError::Read { .. })));
    for text in
        ["", "[]", "{\"schema\": 1}", "{\"schema\": \"1\", \"chapters\": []}", "{\"schema\": 1, \"chapters\": [{}]}"]
    {
        fs::write(&file, text).expect("writable");
        assert!(matches!(Earlier::read(&file), Err(ComparisonError::Malformed { .. })), "{text}");
    }
    fs::write(&file, "{\"schema\": 3, \"chapters\": 7}").expect("writable");
    assert!(matches!(Earlier::read(&file), Err(ComparisonError::Schema { found: 3, .. })));
}

/// Names and meanings of schema 2: a field that is renamed, lost or retyped needs a new version.
#[test]
fn results_keep_to_their_schema() {
    let value: serde_json::Value = serde_json::from_str(&read(&written("schema"), "results.json")).expect("JSON");
    let keys =
        |value: &serde_json::Value| -> Vec<String> { value.as_object().expect("an object").keys().cloned().collect() };
    assert_eq!(keys(&value), ["chapters", "counts", "provenance", "schema"]);
    assert_eq!(keys(&value["counts"]), ["broken", "fail", "inconclusive", "not_run", "not_settled", "pass"]);
    let chapter = &value["chapters"][2];
    let fields =
        ["checks", "counts", "error", "figures", "id", "notes", "question", "sections", "source", "tables", "title"];
    assert_eq!(keys(chapter), fields);
    for chapter in value["chapters"].as_array().expect("chapters") {
        for check in chapter["checks"].as_array().expect("checks") {
            assert_eq!(keys(check), ["id", "measured", "outcome", "reason", "required", "statement"]);
            assert!(
                ["pass", "fail", "inconclusive", "not-settled", "not-run"]
                    .contains(&check["outcome"].as_str().expect("a word"))
            );
        }
        for table in chapter["tables"].as_array().expect("tables") {
            assert_eq!(keys(table), ["caption", "columns", "file", "id", "row_count", "rows"]);
        }
        for figure in chapter["figures"].as_array().expect("figures") {
            assert_eq!(keys(figure), ["caption", "data", "id"]);
        }
        for section in chapter["sections"].as_array().expect("sections") {
            assert_eq!(keys(section), ["figures", "id", "mark", "paragraphs", "tables", "title"]);
        }
    }
}

/// The page of a report as Chromium has it once its scripts have run, and what it said on the console. Where there is no
/// Chromium, nothing is tested, which is said.
fn browsed(report: &Path, fragment: &str) -> Option<(String, Vec<String>)> {
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--enable-logging=stderr", "--v=0", "--virtual-time-budget=2000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", report.join("profile").display()))
        .arg(format!("file://{}{fragment}", report.canonicalize().expect("written").join("index.html").display()))
        .output();
    let output = match output {
        Ok(output) if output.status.success() => output,
        Ok(output) => {
            eprintln!("not run: chromium ended with {}", output.status);
            return None;
        }
        Err(error) => {
            eprintln!("not run: chromium: {error}");
            return None;
        }
    };
    let said = String::from_utf8_lossy(&output.stderr);
    let complaints = said.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect();
    Some((String::from_utf8_lossy(&output.stdout).into_owned(), complaints))
}

/// The page with nasty text in it, in a real browser: its scripts run, nothing is said on the console, and every link within
/// it leads somewhere.
#[test]
fn a_browser_shows_the_page_without_complaint() {
    let path = written("browser");
    // No part has this name, so that the script opens one after the other in search of it.
    let Some((page, complaints)) = browsed(&path, "#nowhere") else { return };
    assert!(complaints.is_empty(), "{complaints:#?}");
    let attribute = |name: &str| -> Vec<String> {
        let opening = format!(" {name}=\"");
        page.split(&opening).skip(1).filter_map(|rest| Some(rest.split_once('"')?.0.to_owned())).collect()
    };
    let ids: HashSet<String> = attribute("id").into_iter().collect();
    let links: Vec<String> =
        attribute("href").iter().filter_map(|to| to.strip_prefix('#').map(str::to_owned)).collect();
    assert!(links.len() > 10, "{} links", links.len());
    assert!(links.iter().all(|link| ids.contains(link)), "{links:?}");
    // Two of them are the sketch that every page has.
    assert!(page.matches("<svg").count() >= 5);
}

/// As many checks, rows and curves as the whole report has: the page stays below two megabytes, since what is folded is packed.
#[test]
fn a_page_as_rich_as_the_whole_report_is_small() {
    let steps = [0.5, 0.25, 0.125];
    let chapter = |place: usize| {
        // Digits that do not repeat from row to row, as measured ones.
        let digits = |n: usize| ((n + 1) as f64 * 0.618_033_988_749_895 * (place + 1) as f64).fract();
        let checks =
            (0..90).map(|n| check(&format!("{n}/method"), Outcome::Pass, Some(2.0 + 0.01 * digits(n)))).collect();
        let rows = (0..250).map(|n| {
            let numbers = (0..6).map(|column| Cell::Number(digits(7 * n + column)));
            [Cell::Text(format!("method-{}", n % 20)), Cell::Text("damped-pendulum".into())]
                .into_iter()
                .chain(numbers)
                .collect()
        });
        let columns = ["method", "problem", "a", "b", "c", "d", "e", "f"];
        let panels = (0..6).map(|n| order_panel("Orders", steps[n % 3] * 1e-9)).collect();
        let (table_id, figure_id) = (format!("t{place}"), format!("f{place}"));
        let figure = Figure { id: figure_id, caption: "Orders.".into(), data: table_id.clone(), panels, columns: 3 };
        let evidence = Evidence {
            checks,
            tables: vec![table(&table_id, &columns, rows.collect(), true)],
            figures: vec![figure],
            ..Evidence::default()
        };
        Chapter { id: format!("c{place}"), title: "Orders".into(), evidence, ..Chapter::default() }
    };
    let path = fresh("size");
    report::write(&Run::new((0..27).map(chapter).collect(), Vec::new()), &path).expect("the report is written");
    let page = fs::read_to_string(path.join("index.html")).expect("the page");
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    assert_eq!(page.matches("class=\"packed\"").count(), 27);
    // Every chapter's evidence is there, to be opened.
    assert!(page.matches("<details class=\"evidence\">").count() >= 27);
}

/// What is not shown is written to its file all the same.
#[test]
fn the_audit_names_every_table_with_what_is_no_number() {
    let table = |shown| Table { shown, ..Table::new("t", "A table.", ["x"], vec![vec![Cell::Number(f64::NAN)]]) };
    for table in [true, false].map(table) {
        let evidence = Evidence { tables: vec![table], ..Evidence::default() };
        let run = Run::new(vec![Chapter { id: "c".into(), evidence, ..Chapter::default() }], Vec::new());
        let failed: Vec<_> = run.checks_that(Outcome::Fail).map(|(_, check)| (&*check.id, &*check.reason)).collect();
        assert_eq!(failed, [("numbers", "1 in `t`")]);
    }
}
