//! Numbers of checks, in all formats.

use roxmltree::{Document, Node};
use serde_json::Value;
use verify::report::{self, Chapter, Run};

use super::*;

#[test]
fn every_format_counts_what_the_run_has() {
    let run = run();
    let path = written("formats", &run);
    let chapters = run.chapters();
    let total = tally(chapters);
    let broken = |chapter: &Chapter| usize::from(chapter.error.is_some());

    let results: Value = serde_json::from_str(&read(&path, "results.json")).expect("JSON");
    let in_json = |counts: &Value| {
        ["pass", "fail", "inconclusive", "not_settled", "not_run", "broken"]
            .map(|key| counts[key].as_u64().expect("a count") as usize)
    };
    let with = |[a, b, c, d, e]: [usize; 5], broken: usize| [a, b, c, d, e, broken];
    assert_eq!(in_json(&results["counts"]), with(total, 1));
    for (chapter, written) in chapters.iter().zip(results["chapters"].as_array().expect("chapters")) {
        assert_eq!(in_json(&written["counts"]), with(tally(std::slice::from_ref(chapter)), broken(chapter)));
        for (table, written) in chapter.evidence.tables.iter().zip(written["tables"].as_array().expect("tables")) {
            assert_eq!(written["row_count"].as_u64(), Some(table.rows.len() as u64), "{}", table.id);
            let file = read(&path, written["file"].as_str().expect("a file"));
            assert_eq!(file.lines().count(), table.rows.len() + 1, "{}", table.id);
        }
    }

    let junit = read(&path, "junit.xml");
    let junit = Document::parse(&junit).expect("XML");
    let suites = with_tag(junit.root(), &["testsuite"]);
    let declared = |node: Node| {
        ["tests", "failures", "errors", "skipped"].map(|key| node.attribute(key).and_then(|n| n.parse().ok()))
    };
    let expected = |[pass, fail, open, not_settled, not_run]: [usize; 5], broken: usize| {
        [pass + fail + open + not_settled + not_run + broken, fail, broken, open + not_settled + not_run].map(Some)
    };
    assert_eq!(declared(junit.root_element()), expected(total, 1));
    for (chapter, suite) in chapters.iter().zip(suites) {
        let counts = tally(std::slice::from_ref(chapter));
        assert_eq!(declared(suite), expected(counts, broken(chapter)), "{}", chapter.id);
        let said = |tag: &str, beginning: &str| {
            let nodes = with_tag(suite, &[tag]).into_iter().filter_map(|node| node.attribute("message"));
            nodes.filter(|message| message.starts_with(beginning)).count()
        };
        let found = [
            said("failure", "Fail"),
            said("skipped", "inconclusive: Incon"),
            said("skipped", "not settled: NotS"),
            said("skipped", "not run: NotRun"),
        ];
        assert_eq!(found, counts[1..], "{}", chapter.id);
    }

    let markdown = read(&path, "report.md");
    let row = |title: &str, [pass, fail, open, not_settled, not_run]: [usize; 5]| {
        format!("| {title} | {pass} | {fail} | {open} | {not_settled} | {not_run} |")
    };
    let words = |counts: [usize; 5], broken: bool| {
        let parts = [(1, "fail"), (2, "inconclusive"), (3, "not settled"), (4, "not run"), (0, "pass")];
        let parts = parts.into_iter().filter(|(place, _)| counts[*place] > 0);
        let start = broken.then(|| "broke off".to_owned());
        let parts = parts.map(|(place, word)| format!("{} {word}", counts[place]));
        start.into_iter().chain(parts).collect::<Vec<_>>().join(", ")
    };
    assert!(markdown.contains(&row("**All**", total)), "{markdown}");
    for chapter in chapters {
        let (counts, is_broken) = (tally(std::slice::from_ref(chapter)), broken(chapter) > 0);
        let title = if is_broken { format!("**{}** (broke off)", chapter.title) } else { chapter.title.clone() };
        assert!(markdown.contains(&row(&title, counts)), "{title} in {markdown}");
        let head = format!("<summary>{}: {}</summary>", chapter.title, words(counts, is_broken));
        assert!(markdown.contains(&head), "{head}");
    }
    for (outcome, (sign, word, ..)) in OUTCOMES.into_iter().zip(FACES) {
        for check in chapters.iter().flat_map(|chapter| &chapter.evidence.checks) {
            let row = format!("| {sign} {word} | {} |", check.statement);
            assert_eq!(markdown.contains(&row), check.outcome == outcome, "{row}");
        }
    }
    for (word, count) in
        [("Fail", total[1]), ("Inconclusive", total[2]), ("Not settled", total[3]), ("Not run", total[4])]
    {
        let (_, list) = markdown.split_once(&format!("## {word} ({count})\n\n")).expect(word);
        assert_eq!(list.lines().take_while(|line| line.starts_with("- **")).count(), count, "{word}");
    }
    assert!(markdown.contains("\n6 more rows in `data/long.csv`."));
    assert_eq!(markdown.matches(" more rows in `").count(), 1, "of a table that is whole nothing is left out");

    let plain = report::summary(&run, false);
    let line = |title: &str| {
        let line = plain.lines().find(|line| line.starts_with(title)).unwrap_or_else(|| panic!("{title} in {plain}"));
        let fields: Vec<usize> =
            line[30..].split_whitespace().filter_map(|n| n.replace('·', "0").parse().ok()).collect();
        fields[fields.len() - 5..].to_vec()
    };
    assert_eq!(line("All"), total);
    for chapter in chapters {
        assert_eq!(line(&chapter.title), tally(std::slice::from_ref(chapter)), "{}", chapter.title);
        assert_eq!(plain.contains(&format!("{:18} (broke off)", chapter.title)), broken(chapter) > 0);
    }

    // What failed comes first, before the list is cut.
    let points: Vec<&str> = plain.lines().skip_while(|line| !line.starts_with("All")).skip(1).collect();
    let points: Vec<&str> = points.into_iter().filter(|line| !line.is_empty()).collect();
    let failed = total[1] + 1;
    assert!(points[..failed].iter().all(|line| line.starts_with('✗')), "{plain}");
    assert!(!points[failed].starts_with('✗'), "{plain}");

    let page = page(&path);
    let document = Document::parse(&page).expect("a tree");
    let summary = element(&document, "_summary");
    let tiles = with_tag(with_class(summary, "checked")[0], &["li"]);
    let tiles: Vec<_> = tiles.iter().map(|tile| text(*tile)).collect();
    let said = FACES.iter().zip(total).map(|((sign, word, ..), count)| format!("{count} {sign} {word}"));
    assert_eq!(tiles, said.collect::<Vec<_>>());
    assert!(text(summary).contains(&format!("{} checks", total.iter().sum::<usize>())));
    let heads = with_tag(document.root(), &["h2"]).into_iter();
    let ordinals: Vec<_> = heads.flat_map(|head| with_class(head, "ordinal")).map(text).collect();
    assert_eq!(ordinals, (1..=chapters.len()).map(|n| n.to_string()).collect::<Vec<_>>());
    // The fold of a chapter tells what passed; that of the answers, which stand in sight, is none.
    let id = |chapter: &Chapter| chapter.id.clone();
    for (chapter, pass) in chapters.iter().map(|chapter| (chapter, tally(std::slice::from_ref(chapter))[0])) {
        let folds = with_tag(element(&document, &id(chapter)), &["summary"]);
        let told: Vec<_> = folds.into_iter().map(text).filter(|fold| fold.contains(" that passed")).collect();
        let word = if pass == 1 { "check" } else { "checks" };
        let ends = told.iter().map(|fold| fold.ends_with(&format!("{pass} {word} that passed")));
        assert_eq!(ends.collect::<Vec<_>>(), vec![true; told.len()], "{told:?}");
        assert!(told.len() == 1 || chapter.id == "model" || chapter.id == "answers", "{}: {told:?}", chapter.id);
    }
    let heads: Vec<_> = with_tag(summary, &["h3", "summary"]).into_iter().map(text).collect();
    let settled = format!("Not settled ({}): 2 reasons", total[3]);
    let not_run = format!("Not run ({}): 2 reasons", total[4]);
    let [fail, open] = [(1, "Fail"), (2, "Inconclusive")].map(|(place, word)| format!("{word} ({})", total[place]));
    assert_eq!(heads, ["Studies that broke off".to_owned(), fail, open, settled, not_run]);
    let contents = with_tag(element(&document, "_contents"), &["li"]);
    let shown: Vec<_> = contents.into_iter().map(|entry| only(&with_class(entry, "sign"))).collect();
    let states = CHAPTERS.iter().map(|chapter| FACES[chapter.3]).chain([FACES[0]]);
    for ((chapter, sign), (symbol, _, class, _)) in chapters.iter().zip(shown).zip(states) {
        let counts = tally(std::slice::from_ref(chapter));
        assert_eq!(sign.attribute("title"), Some(words(counts, broken(chapter) > 0).as_str()));
        assert_eq!((text(sign).as_str(), classes(&sign)), (symbol, vec!["sign", class]), "{}", chapter.id);
    }
}

#[test]
fn what_is_not_well_is_said_first_and_in_red() {
    let well = ["answers", "idle", "open", "tried"];
    let well: Vec<Chapter> = CHAPTERS.into_iter().filter(|(id, ..)| well.contains(id)).map(chapter).collect();
    let cases = [
        (well.clone(), "no check failed, 40 of 93 passed", "good", "32"),
        ([well.clone(), vec![chapter(CHAPTERS[6])]].concat(), "1 study broke off", "bad", "31"),
        ([well, vec![chapter(CHAPTERS[2])]].concat(), "2 checks failed", "bad", "31"),
        (CHAPTERS.map(chapter).into(), "2 checks failed, 1 study broke off", "bad", "31"),
    ];
    for (chapters, said, class, colour) in cases {
        let run = Run::new(chapters, Vec::new());
        let path = written("headline", &run);
        let page = page(&path);
        let document = Document::parse(&page).expect("a tree");
        let headline = only(&with_class(document.root(), "headline"));
        assert_eq!(text(headline).to_lowercase(), format!("{said}."));
        assert_eq!(classes(&headline), ["headline", class]);
        let checked = only(&with_class(document.root(), "checked"));
        for tile in with_tag(checked, &["li"]) {
            let is_empty = text(tile).starts_with("0 ");
            assert_eq!(classes(&tile).contains(&"none"), is_empty, "{}", text(tile));
        }
        assert!(report::summary(&run, true).contains(&format!("\n\u{1b}[{colour}m{said}\u{1b}[0m\n")), "{said}");
        assert!(read(&path, "report.md").starts_with(&format!("# Verification: {said}\n")));
    }
    // The colours of a line with all five.
    let coloured = report::summary(&run(), true);
    let line = coloured.lines().find(|line| line.starts_with("The claims chapter")).expect("its line");
    let numbers = [("32", 6, 7), ("31", 6, 2), ("33", 13, 3), ("33", 12, 11), ("33", 8, 5)];
    let numbers = numbers.map(|(colour, width, count)| format!("\u{1b}[{colour}m{count:>width$}\u{1b}[0m"));
    assert!(line.ends_with(&numbers.join(" ")), "{line:?}");
}

#[test]
fn a_failure_says_what_was_required() {
    let check = Check {
        id: "late".into(),
        statement: "It is early".into(),
        outcome: Outcome::Fail,
        measured: Some(2.5),
        required: Some(Requirement::AtMost(1.25)),
        reason: String::new(),
    };
    let evidence = Evidence { checks: vec![check], ..Evidence::default() };
    let run =
        Run::new(vec![Chapter { id: "time".into(), title: "Time".into(), evidence, ..Chapter::default() }], Vec::new());
    let junit = read(&written("required", &run), "junit.xml");
    let junit = Document::parse(&junit).expect("XML");
    let failures = with_tag(junit.root(), &["failure"]);
    let messages: Vec<_> = failures.iter().filter_map(|node| node.attribute("message")).collect();
    assert_eq!(messages, ["It is early. Measured 2.5, required ≤ 1.25."]);
}

/// The screen has lines for twelve, and the report has a chapter on itself.
#[test]
fn the_summary_of_many_chapters_shows_those_that_failed() {
    let chapter = |n: usize| Chapter {
        id: format!("plain-{n}"),
        title: format!("Chapter {n}"),
        ..chapter(("plain", [3, usize::from(n == 13), 0, 0, 0], false, 0))
    };
    let text = report::summary(&Run::new((1..=13).map(chapter).collect(), Vec::new()), false);
    assert!(text.contains("Chapter 13") && !text.contains("Chapter 12"), "{text}");
    assert!(text.contains("… and 2 more chapters\n"), "{text}");
}
