//! Words, signs and colours of verdicts and outcomes on the page.

use super::*;

/// The colours that a class has by the rules for it alone.
fn colours(style: &str, class: &str) -> Vec<String> {
    let mut found = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (place, c) in style.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth -= 1;
                if depth == 0 {
                    let (selectors, body) = style[start..place].split_once('{').expect("a rule");
                    let selectors = selectors.rsplit("*/").next().unwrap_or_default();
                    if selectors.split(',').any(|selector| selector.trim() == format!(".{class}")) {
                        let declared = body.split(';').filter_map(|line| line.trim().strip_prefix("color:"));
                        found.extend(declared.map(|value| value.trim().to_owned()));
                    }
                    start = place + 1;
                }
            }
            _ => {}
        }
    }
    found
}

#[test]
fn every_verdict_and_outcome_has_its_word_sign_and_colour_wherever_it_stands() {
    let run = run();
    let path = written("faces", &run);
    let whole = read(&path, "index.html");
    let (_, style) = whole.split_once("<style>").expect("a style");
    let (style, _) = style.split_once("</style>").expect("its end");
    let faces = VERDICTS.map(|(_, class, colour, _)| (class, colour));
    for (class, colour) in faces.into_iter().chain(FACES.map(|(_, _, class, colour)| (class, colour))) {
        assert_eq!(colours(style, class), [format!("var({colour})")], "{class}");
    }
    assert_eq!([colours(style, "good"), colours(style, "bad")], [["var(--good)"], ["var(--bad)"]]);
    // By day, by night and on paper.
    for name in ["good", "bad", "warn", "mute"] {
        let values = |name: &str| -> Vec<String> {
            style.split(&format!("--{name}:")).skip(1).map(|rest| rest[..9].trim().to_owned()).collect()
        };
        assert_eq!(values(name).len(), 3, "{name}");
        for other in ["good", "bad", "warn", "mute"].iter().filter(|other| **other != name) {
            assert!(values(name).iter().zip(values(other)).all(|(a, b)| *a != b), "{name} and {other} look alike");
        }
    }

    let page = page(&path);
    let document = Document::parse(&page).expect("a tree");
    let summary = element(&document, "_summary");
    let tiles = with_tag(with_class(summary, "tiles")[0], &["li"]);
    assert_eq!(tiles.len(), VERDICTS.len());
    assert!(text(summary).starts_with("24 claims of the papers"));
    for (tile, (word, class, _, count)) in tiles.into_iter().zip(VERDICTS) {
        assert_eq!((text(tile), classes(&tile)), (format!("{count} {word}"), vec![class]));
    }
    let tiles = with_tag(with_class(summary, "checked")[0], &["li"]);
    assert_eq!(tiles.iter().map(|tile| classes(tile)[0]).collect::<Vec<_>>(), FACES.map(|face| face.2));
    let claims = run.chapters().iter().find(|chapter| chapter.id == "claims").expect("made up");
    let rows = with_tag(element(&document, "table:claims"), &["tr"]);
    for (part, row) in claims.evidence.sections.iter().zip(&rows[1..]) {
        let class = VERDICTS.iter().find(|verdict| verdict.0 == part.mark).expect("made up").1;
        for place in [element(&document, &part.id), *row] {
            let mark = only(&with_class(place, "mark"));
            assert_eq!((text(mark), classes(&mark)), (part.mark.clone(), vec!["mark", class]), "{}", part.id);
        }
    }

    for chapter in run.chapters() {
        for check in &chapter.evidence.checks {
            let place = element(&document, &format!("{}/{}", chapter.id, check.id));
            let (sign, word, class, _) = FACES[OUTCOMES.iter().position(|o| *o == check.outcome).expect("one of five")];
            assert!(text(place).contains(&check.statement.replace('`', "")), "{}", check.statement);
            let folded = place.ancestors().any(|node| node.has_tag_name("details"));
            assert!(
                !folded || matches!(check.outcome, Outcome::Pass | Outcome::NotSettled | Outcome::NotRun),
                "{} is out of sight",
                check.id
            );
            if [Outcome::NotSettled, Outcome::NotRun].contains(&check.outcome) {
                let list = place.ancestors().find(|node| node.has_tag_name("details")).expect("a fold");
                assert_eq!(classes(&list), [class]);
                let reason = check.reason.trim_start_matches("not run: ");
                assert!(
                    text(list).starts_with(&format!("{sign} {word} (")) && text(list).contains(reason),
                    "{}",
                    text(list)
                );
                continue;
            }
            let badge = only(&with_class(place, "badge"));
            assert_eq!((text(badge), classes(&badge)), (format!("{sign} {word}"), vec!["badge", class]));
            let number = only(&with_class(place, "number"));
            let whole: f64 =
                number.attribute("title").map_or_else(|| text(number), str::to_owned).parse().expect("read");
            assert_eq!(Some(whole), check.measured, "the whole number stands behind the short one");
        }
    }
}
