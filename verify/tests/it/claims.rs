//! The claims are complete and stated.

use std::collections::HashSet;

use verify::claim;

#[test]
fn every_claim_of_both_papers_is_there_once() {
    let claims = claim::all();
    let ids: HashSet<_> = claims.iter().map(|claim| claim.id).collect();
    assert_eq!(ids.len(), claims.len(), "an identifier is used twice");
    let letters = |paper: &str| -> Vec<String> {
        let prefix = format!("{paper}-");
        let mut letters: Vec<_> = ids.iter().filter_map(|id| id.strip_prefix(&prefix)).map(str::to_owned).collect();
        letters.sort();
        letters.iter_mut().for_each(|id| id.truncate(1));
        letters.dedup();
        letters
    };
    let alphabet = |last: char| ('a'..=last).map(String::from).collect::<Vec<_>>();
    assert_eq!(letters("S24"), alphabet('q'));
    assert_eq!(letters("KY21"), alphabet('h'));
    // The parts of a claim are numbered from 1 on.
    for id in &ids {
        let Some((claim, part)) = id.rsplit_once('-').filter(|(_, part)| part.parse::<u32>().is_ok()) else { continue };
        assert!(!ids.contains(claim), "{claim} has parts and stands alone");
        let part: u32 = part.parse().expect("just parsed");
        assert!((1..=part).all(|n| ids.contains(format!("{claim}-{n}").as_str())), "{id} has no predecessor");
    }
}

#[test]
fn every_claim_says_where_it_stands_and_how_it_is_judged() {
    for claim in claim::all() {
        let paper = claim.id.split('-').next().unwrap_or_default();
        assert!(claim.source.starts_with(&format!("[{paper}]")), "{}: {}", claim.id, claim.source);
        assert!(claim.statement.ends_with(['.', '?']) && claim.criterion.ends_with('.'), "{}", claim.id);
    }
}
