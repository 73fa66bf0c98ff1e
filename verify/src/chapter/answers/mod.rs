//! What a reader comes for: which method to take, and what it costs. Each answer rests on runs made for it.

mod methods;
mod parabolic;
mod path_fitting;
mod ringing;
mod smooth;
mod trust;

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Check, Evidence, Figure, Outcome, Section, Table};

pub(super) const STUDY: Study = Study {
    id: "answers",
    title: "In short",
    question: "Which of these methods should I take, and what would I lose?",
    source: "runs made for these questions; the chapters below have the details",
    run: study,
};

/// An answer to one question.
struct Answer {
    id: &'static str,
    question: &'static str,
    /// In a word or two; shown only if every check holds.
    short: String,
    /// The text with its placeholders filled. The first paragraph is the caption of the figure, if there is one; every other
    /// begins with a label and a colon. The one labelled `Short` is the sentence of the first screen.
    text: Vec<String>,
    checks: Vec<Check>,
    figure: Option<Figure>,
    table: Table,
}

fn study(context: &Context) -> Result<Evidence, StudyError> {
    let mut evidence = Evidence::default();
    methods::tell(context, &mut evidence)?;
    for answer in [parabolic::answer, ringing::answer, path_fitting::answer, smooth::answer, trust::answer] {
        answer(context)?.tell(&mut evidence)?;
    }
    Ok(evidence)
}

impl Answer {
    fn tell(self, evidence: &mut Evidence) -> Result<(), StudyError> {
        let Self { id, question, short, text, checks, figure, table } = self;
        let holds = checks.iter().all(|check| check.outcome == Outcome::Pass);
        let labelled = |text: &String| {
            let (label, text) = text.split_once(": ").ok_or("a paragraph of an answer has a label")?;
            Ok::<_, StudyError>((label.to_owned(), text.to_owned()))
        };
        let mut section = Section {
            id: id.into(),
            title: question.into(),
            mark: if holds { short } else { "unsettled".into() },
            ..Section::default()
        };
        let mut rest = text.iter();
        if let Some(figure) = figure {
            section.figures.push(figure.id.clone());
            let caption = rest.next().cloned().unwrap_or_default();
            evidence.figures.push(Figure { caption, ..figure });
        }
        section.paragraphs = rest.map(labelled).collect::<Result<_, _>>()?;
        evidence.checks.extend(checks);
        evidence.sections.push(section);
        evidence.tables.push(table);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_stands_beside_a_question_only_if_every_check_holds() {
        let mark = |outcomes: &[Outcome]| {
            let check = |outcome: &Outcome| Check::undecided("c", "It holds", *outcome, "");
            let answer = Answer {
                id: "a",
                question: "Is it so?",
                short: "yes".into(),
                text: vec!["Short: It is.".into()],
                checks: outcomes.iter().map(check).collect(),
                figure: None,
                table: Table::new("t", "", [""], Vec::new()),
            };
            let mut evidence = Evidence::default();
            answer.tell(&mut evidence).expect("it has a label");
            evidence.sections[0].mark.clone()
        };
        let pass = Outcome::Pass;
        assert_eq!(mark(&[pass, pass]), "yes");
        for other in [Outcome::Fail, Outcome::Inconclusive, Outcome::NotSettled, Outcome::NotRun] {
            assert_eq!(mark(&[pass, other, pass]), "unsettled", "{other:?}");
        }
    }
}
