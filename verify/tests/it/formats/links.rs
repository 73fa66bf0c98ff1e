//! Where the links of the page lead, and in which order its first screen tells.

use super::*;

/// What an element is called by those who read it.
fn name(element: Node) -> String {
    let named = match element.tag_name().name() {
        "section" => with_tag(element, &["h2", "h3"]).into_iter().next(),
        "tr" => with_tag(element, &["td"]).into_iter().nth(1),
        "div" => with_class(element, "caption").into_iter().next(),
        "figure" => with_tag(element, &["figcaption"]).into_iter().next(),
        _ => None,
    };
    text(named.unwrap_or(element))
}

#[test]
fn every_link_leads_to_what_it_names() {
    let path = written("links", &run());
    let page = page(&path);
    let document = Document::parse(&page).expect("a tree");
    let mut count = [0; 5];
    for link in with_tag(document.root(), &["a"]) {
        let Some(id) = link.attribute("href").and_then(|to| to.strip_prefix('#')) else { continue };
        let (target, said) = (element(&document, id), text(link));
        let is_of = |class: &str| classes(&link).contains(&class);
        let map = link.ancestors().find(|node| classes(node).contains(&"grid"));
        let kind = match map {
            _ if is_of("permalink") => {
                let whole =
                    |node: &Node| node.is_element() && ["section", "div", "figure"].contains(&node.tag_name().name());
                let around = link.ancestors().find(|node| whole(node) && node.attribute("id").is_some());
                assert_eq!(around, Some(target), "{id}");
                0
            }
            _ if is_of("skip") => {
                assert_eq!(id, "_answers");
                1
            }
            Some(map) => {
                let cell = link.parent().expect("a cell");
                let row = cell.parent().expect("a row");
                let column = row.children().position(|sibling| sibling == cell).expect("there");
                let heads = with_tag(only(&with_tag(map, &["thead"])), &["td", "th"]);
                for part in [text(heads[column]), text(only(&with_tag(row, &["th"])))] {
                    assert!(
                        name(target).starts_with(&part) || name(target).contains(&format!(" {part} ")),
                        "{part}: {id}"
                    );
                }
                2
            }
            None if said == "Terms" || said.ends_with(" claims of the papers") => {
                assert_eq!(id, if said == "Terms" { "_terms" } else { "claims" });
                3
            }
            None => {
                assert!(name(target).contains(&said), "“{said}” leads to “{}”", name(target));
                if let Some(place) = link.next_siblings().find(|node| classes(node).contains(&"where")) {
                    let chapter =
                        target.ancestors().find(|node| classes(node).contains(&"chapter")).expect("a chapter");
                    assert!(name(chapter).contains(&text(place)), "{said}");
                }
                4
            }
        };
        count[kind] += 1;
    }
    // Of the last kind are the contents, the answers, what did not pass and the rows of the table of claims.
    let [permalinks, skip, cells, named, others] = count;
    assert!(permalinks > 30 && skip == 1 && cells == 3 && named == 2, "{count:?}");
    assert_eq!(others, 8 + 2 + 3 + 1 + (2 + 9 + 38 + 25) + 24);
}

/// Which method to take for a model of one's own comes first, then the questions in their order, each with its word.
#[test]
fn the_first_screen_tells_the_recommendation_and_the_answers_and_no_claim() {
    let path = written("told", &run());
    let page = page(&path);
    let document = Document::parse(&page).expect("a tree");
    let told: Vec<_> = with_tag(element(&document, "_answers"), &["li"]).into_iter().map(text).collect();
    let sentence = |id: &str, mark: &str| format!("What of {id} {mark}The sentence of {id}.");
    assert_eq!(told, [sentence("model-recommendation", ""), sentence("first", "no "), sentence("second", "yes ")]);
}
