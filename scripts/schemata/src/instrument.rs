//! Puts all mutants of a source file beside what they replace, each behind a question which of them is active.
//!
//! `a * b` becomes `match (a, b) { (l, r) => match at(7, 2) { 1 => l + r, 2 => l / r, _ => l * r } }`: operands stand once, however
//! deep they nest.

use std::collections::HashMap;
use std::ops::Range;

use proc_macro2::LineColumn;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr};

use crate::list::{Genre, Mutant};

/// What stands where in the instrumented text.
#[derive(Debug)]
pub struct Place {
    pub text: Range<usize>,
    /// The mutants of the place.
    pub mutants: Vec<u32>,
}

/// The instrumented text of a file, its places, outer ones first, and the mutants' own texts in it.
#[derive(Debug, Default)]
pub struct Instrumented {
    pub text: String,
    pub places: Vec<Place>,
    pub alternatives: Vec<Place>,
}

/// Instruments `source` with its mutants; those that find no place are in none of the result's.
pub fn instrument(source: &str, mutants: &[&Mutant]) -> syn::Result<Instrumented> {
    let file = syn::parse_file(source)?;
    let lines: Vec<usize> = std::iter::once(0).chain(source.match_indices('\n').map(|(i, _)| i + 1)).collect();
    let mut at = HashMap::<_, Vec<&Mutant>>::new();
    for mutant in mutants {
        let start = offset(source, &lines, mutant.span.start.line, mutant.span.start.column - 1);
        at.entry((mutant.genre, start)).or_default().push(mutant);
    }
    let mut found = Finder { source, lines: &lines, at, edits: Vec::new(), places: Vec::new() };
    found.visit_file(&file);
    Ok(found.write(0..source.len()))
}

fn offset(source: &str, lines: &[usize], line: usize, column: usize) -> usize {
    let start = lines[line - 1];
    source[start..].char_indices().nth(column).map_or(source.len(), |(i, _)| start + i)
}

/// A piece of new text.
#[derive(Debug)]
enum Piece {
    Text(String),
    Mutant(u32, String),
    Instrumented(Instrumented),
}

#[derive(Debug)]
struct Edit {
    replaced: Range<usize>,
    pieces: Vec<Piece>,
    place: usize,
    side: Side,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Begin,
    Within,
    End,
}

#[derive(Debug)]
struct Finder<'a> {
    source: &'a str,
    lines: &'a [usize],
    at: HashMap<(Genre, usize), Vec<&'a Mutant>>,
    edits: Vec<Edit>,
    places: Vec<Vec<u32>>,
}

fn text(s: impl Into<String>) -> Vec<Piece> {
    vec![Piece::Text(s.into())]
}

/// `match at(…) { 1 => …, 2 => …, _ => `.
fn arms(mutants: &[&Mutant], of: impl Fn(&Mutant) -> String) -> Vec<Piece> {
    // Some in between may be gone.
    let first = mutants[0].id;
    let all = mutants[mutants.len() - 1].id - first + 1;
    let mut pieces = text(format!("match crate::schemata::at({first}, {all}) {{ "));
    for mutant in mutants {
        pieces.push(Piece::Text(format!("{} => ", mutant.id - first + 1)));
        pieces.push(Piece::Mutant(mutant.id, of(mutant)));
        pieces.push(Piece::Text(", ".into()));
    }
    pieces.push(Piece::Text("_ => ".into()));
    pieces
}

fn join(pieces: impl IntoIterator<Item = Vec<Piece>>) -> Vec<Piece> {
    pieces.into_iter().flatten().collect()
}

impl<'a> Finder<'a> {
    fn offset(&self, at: LineColumn) -> usize {
        offset(self.source, self.lines, at.line, at.column)
    }

    fn range(&self, of: &impl Spanned) -> Range<usize> {
        let span = of.span();
        self.offset(span.start())..self.offset(span.end())
    }

    fn take(&mut self, genre: Genre, start: usize) -> Option<Vec<&'a Mutant>> {
        self.at.remove(&(genre, start))
    }

    fn place(&mut self, mutants: &[&Mutant], edits: impl IntoIterator<Item = (Side, Range<usize>, Vec<Piece>)>) {
        let place = self.places.len();
        self.places.push(mutants.iter().map(|mutant| mutant.id).collect());
        self.edits.extend(edits.into_iter().map(|(side, replaced, pieces)| Edit { replaced, pieces, place, side }));
    }

    /// Adds what stands before and after `inner`.
    fn wrap(&mut self, mutants: &[&Mutant], inner: Range<usize>, before: Vec<Piece>, after: Vec<Piece>) {
        let (begin, end) = (inner.start..inner.start, inner.end..inner.end);
        self.place(mutants, [(Side::Begin, begin, before), (Side::End, end, after)]);
    }

    fn function(&mut self, signature: &syn::Signature, body: &syn::Block) {
        let Some(first) = body.stmts.first() else { return };
        if signature.constness.is_some() {
            return;
        }
        // Two values of one opaque type would have to be of one type.
        let is_opaque =
            matches!(&signature.output, syn::ReturnType::Type(_, of) if matches!(**of, syn::Type::ImplTrait(_)));
        let start = self.range(first).start;
        if !is_opaque && let Some(mutants) = self.take(Genre::FnValue, start) {
            let brace = self.range(&body.brace_token.span.open()).end;
            let before = join([arms(&mutants, |m| format!("return {}", m.replacement)), text("{} };\n")]);
            self.place(&mutants, [(Side::Begin, brace..brace, before)]);
        }
        visit::visit_block(self, body);
    }

    /// Whether the left operand has been instrumented too, to be put elsewhere.
    fn binary(&mut self, e: &syn::ExprBinary) -> bool {
        let operator = self.range(&e.op);
        if has_let(&e.left) || has_let(&e.right) {
            return false;
        }
        let Some(mutants) = self.take(Genre::BinaryOperator, operator.start) else { return false };
        let original = self.source[operator.clone()].to_string();
        let choice = |l: &str, r: &str| {
            let of = |operator: &str| format!("{l} {operator} {r}");
            join([arms(&mutants, |m| of(&m.replacement)), text(of(&original) + " }")])
        };
        let all = self.range(e);
        let (before, between, after) = match e.op {
            BinOp::And(_) | BinOp::Or(_) => {
                let is = if matches!(e.op, BinOp::And(_)) { "!=" } else { "==" };
                let condition = format!(") {{ l => if l {is} (crate::schemata::at({}, 1) == 1) {{ ", mutants[0].id);
                ("(match (", condition, text(" } else { l } })"))
            }
            BinOp::Eq(_) | BinOp::Ne(_) | BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) => {
                ("(match (&(", "), &(".into(), join([text(")) { (l, r) => "), choice("*l", "*r"), text(" })")]))
            }
            _ if is_assignment(&e.op) => {
                // The right operand comes first, as it does for numbers.
                let left = vec![Piece::Instrumented(self.within(&e.left))];
                let begin = text(") { r => { let l = &mut (");
                let after = join([begin, left, text("); "), choice("*l", "r"), text("; } })")]);
                let right = self.range(&*e.right);
                let begin = (Side::Begin, all.start..right.start, text("(match ("));
                self.place(&mutants, [begin, (Side::End, right.end..right.end, after)]);
                return true;
            }
            _ => ("(match (", ", ".into(), join([text(") { (l, r) => "), choice("l", "r"), text(" })")])),
        };
        let (begin, end) = (all.start..all.start, all.end..all.end);
        let between = (Side::Within, operator, text(between));
        self.place(&mutants, [(Side::Begin, begin, text(before)), between, (Side::End, end, after)]);
        false
    }

    /// The instrumented text of an expression.
    fn within(&mut self, e: &Expr) -> Instrumented {
        let range = self.range(e);
        let at = std::mem::take(&mut self.at);
        let mut inner = Finder { source: self.source, lines: self.lines, at, edits: Vec::new(), places: Vec::new() };
        inner.visit_expr(e);
        self.at = std::mem::take(&mut inner.at);
        inner.write(range)
    }

    fn write(mut self, of: Range<usize>) -> Instrumented {
        // Where several edits begin at one position, inner places end before outer ones, and begin after them.
        self.edits.sort_by_key(|edit| {
            let place = edit.place as i64;
            (edit.replaced.start, if edit.side == Side::End { (0, -place) } else { (1, place) })
        });
        let (mut out, mut at) = (Instrumented::default(), of.start);
        let mut texts: Vec<Option<Range<usize>>> = vec![None; self.places.len()];
        for edit in self.edits {
            out.text.push_str(&self.source[at..edit.replaced.start]);
            at = edit.replaced.end;
            let begin = out.text.len();
            for piece in edit.pieces {
                out.push(piece);
            }
            // All that a place writes is between its first edit and its last.
            let start = texts[edit.place].take().map_or(begin, |text| text.start);
            texts[edit.place] = Some(start..out.text.len());
        }
        out.text.push_str(&self.source[at..of.end]);
        let texts = texts.into_iter().map(Option::unwrap_or_default);
        out.places.extend(texts.zip(self.places).map(|(text, mutants)| Place { text, mutants }));
        out
    }
}

impl Instrumented {
    fn push(&mut self, piece: Piece) {
        let start = self.text.len();
        match piece {
            Piece::Text(text) => self.text.push_str(&text),
            Piece::Mutant(id, text) => {
                self.text.push_str(&text);
                self.alternatives.push(Place { text: start..self.text.len(), mutants: vec![id] });
            }
            Piece::Instrumented(inner) => {
                self.text.push_str(&inner.text);
                let shifted = |place: Place| Place { text: place.text.start + start..place.text.end + start, ..place };
                self.places.extend(inner.places.into_iter().map(shifted));
                self.alternatives.extend(inner.alternatives.into_iter().map(shifted));
            }
        }
    }

    /// The mutants that make the text wrong at a position: one of several, or those of the smallest place around it.
    pub fn blame(&self, at: usize) -> Option<&[u32]> {
        let around = |places: &[Place]| {
            let around = places.iter().enumerate().filter(|(_, place)| place.text.contains(&at));
            around.min_by_key(|(_, place)| place.text.len()).map(|(i, _)| i)
        };
        let alternative = around(&self.alternatives).map(|i| &self.alternatives[i]);
        let place = || around(&self.places).map(|i| &self.places[i]);
        alternative.or_else(place).map(|place| &place.mutants[..])
    }
}

fn is_assignment(op: &BinOp) -> bool {
    use BinOp::*;
    matches!(
        op,
        AddAssign(_)
            | SubAssign(_)
            | MulAssign(_)
            | DivAssign(_)
            | RemAssign(_)
            | BitXorAssign(_)
            | BitAndAssign(_)
            | BitOrAssign(_)
            | ShlAssign(_)
            | ShrAssign(_)
    )
}

/// Whether it is part of a chain with `let`, which must stay one.
fn has_let(e: &Expr) -> bool {
    match e {
        Expr::Let(_) => true,
        Expr::Binary(e) => matches!(e.op, BinOp::And(_)) && (has_let(&e.left) || has_let(&e.right)),
        _ => false,
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_fn(&mut self, f: &'ast syn::ItemFn) {
        self.function(&f.sig, &f.block);
    }

    fn visit_impl_item_fn(&mut self, f: &'ast syn::ImplItemFn) {
        self.function(&f.sig, &f.block);
    }

    fn visit_trait_item_fn(&mut self, f: &'ast syn::TraitItemFn) {
        if let Some(body) = &f.default {
            self.function(&f.sig, body);
        }
    }

    // What the compiler computes cannot ask.
    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}
    fn visit_expr_repeat(&mut self, e: &'ast syn::ExprRepeat) {
        self.visit_expr(&e.expr);
    }

    fn visit_expr_binary(&mut self, e: &'ast syn::ExprBinary) {
        if !self.binary(e) {
            self.visit_expr(&e.left);
        }
        self.visit_expr(&e.right);
    }

    fn visit_expr_unary(&mut self, e: &'ast syn::ExprUnary) {
        let operator = self.range(&e.op);
        if let Some(mutants) = self.take(Genre::UnaryOperator, operator.start) {
            let original = format!("{}x }} }})", &self.source[operator.clone()]);
            let end = self.range(e).end;
            let after = join([text(") { x => "), arms(&mutants, |_| "x".into()), text(original)]);
            self.place(&mutants, [(Side::Begin, operator, text("(match (")), (Side::End, end..end, after)]);
        }
        self.visit_expr(&e.expr);
    }

    fn visit_expr_match(&mut self, e: &'ast syn::ExprMatch) {
        let takes_all =
            |arm: &syn::Arm| arm.guard.is_none() && matches!(arm.pat, syn::Pat::Wild(_) | syn::Pat::Ident(_));
        if !e.arms.iter().any(takes_all) {
            // Without one of its arms it would not compile.
            for arm in &e.arms {
                self.take(Genre::MatchArm, self.range(arm).start);
            }
        }
        visit::visit_expr_match(self, e);
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        let pattern = self.range(&arm.pat);
        if let Some(mutants) = self.take(Genre::MatchArm, self.range(arm).start) {
            let is_there = format!("crate::schemata::at({}, 1) == 0", mutants[0].id);
            match &arm.guard {
                Some((_, guard)) if !has_let(guard) => {
                    let guard = self.range(&**guard);
                    self.wrap(&mutants, guard, text(format!("{is_there} && (")), text(")"));
                }
                Some(_) => {}
                None => {
                    let end = pattern.end..pattern.end;
                    self.place(&mutants, [(Side::End, end, text(format!(" if {is_there}")))]);
                }
            }
        }
        if let Some((_, guard)) = &arm.guard {
            if !has_let(guard)
                && let Some(mutants) = self.take(Genre::MatchArmGuard, self.range(&**guard).start)
            {
                let guard = self.range(&**guard);
                self.wrap(&mutants, guard, arms(&mutants, |m| m.replacement.clone()), text(" }"));
            }
            self.visit_expr(guard);
        }
        self.visit_expr(&arm.body);
    }

    fn visit_expr_struct(&mut self, e: &'ast syn::ExprStruct) {
        if let Some(rest) = &e.rest {
            for field in &e.fields {
                let start = self.range(field).start;
                if let (Some(mutants), syn::Member::Named(name)) = (self.take(Genre::StructField, start), &field.member)
                {
                    let name_of_short = if field.colon_token.is_none() { format!("{name}: ") } else { String::new() };
                    let (path, base) = (&self.source[self.range(&e.path)], &self.source[self.range(&**rest)]);
                    let of_rest = match **rest {
                        Expr::Path(_) => format!("{base}.{name}.clone()"),
                        _ => format!("{{ let rest: {path} = {base}; rest.{name} }}"),
                    };
                    let before = join([text(name_of_short), arms(&mutants, |_| of_rest.clone())]);
                    self.wrap(&mutants, self.range(&field.expr), before, text(" }"));
                }
            }
        }
        visit::visit_expr_struct(self, e);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::list::{Position, Span};

    fn instrumented(source: &str, mutants: &[(Genre, &str, &str)]) -> Instrumented {
        let mutants: Vec<_> = mutants
            .iter()
            .enumerate()
            .map(|(i, &(genre, of, replacement))| Mutant {
                id: i as u32 + 1,
                name: String::new(),
                file: String::new(),
                genre,
                replacement: replacement.into(),
                span: Span { start: Position { line: 1, column: 1 + source.find(of).expect("there") } },
            })
            .collect();
        instrument(source, &mutants.iter().collect::<Vec<_>>()).expect("a source")
    }

    #[test]
    fn operands_stand_once_however_deep_they_nest() {
        use Genre::BinaryOperator;
        let new = instrumented(
            "fn f(a: i32) -> i32 { a * 2 + 1 }",
            &[(BinaryOperator, "*", "/"), (BinaryOperator, "+", "-")],
        );
        let product = "(match (a ,  2) { (l, r) => match crate::schemata::at(1, 1) { 1 => l / r, _ => l * r } })";
        let sum = format!(
            "(match ({product} ,  1) {{ (l, r) => match crate::schemata::at(2, 1) {{ 1 => l - r, _ => l + r }} }})"
        );
        assert_eq!(new.text, format!("fn f(a: i32) -> i32 {{ {sum} }}"));
        assert_eq!(new.blame(new.text.find("l - r").expect("there")), Some(&[2][..]));
        assert_eq!(new.blame(new.text.find("l * r").expect("there")), Some(&[1][..]));
        assert_eq!(new.blame(0), None);
    }

    #[test]
    fn of_two_conditions_the_second_is_asked_for_where_it_was_or_would_be() {
        let new = instrumented("fn f(a: bool, b: bool) -> bool { a && b }", &[(Genre::BinaryOperator, "&&", "||")]);
        let expected = "(match (a ) { l => if l != (crate::schemata::at(1, 1) == 1) {  b } else { l } })";
        assert_eq!(new.text, format!("fn f(a: bool, b: bool) -> bool {{ {expected} }}"));
    }

    #[test]
    fn what_is_added_to_has_its_own_mutants() {
        use Genre::BinaryOperator;
        let new = instrumented(
            "fn f(x: &mut [f64]) { x[0 + 1] += 2.0 }",
            &[(BinaryOperator, "+", "-"), (BinaryOperator, "+=", "-=")],
        );
        let index = "x[(match (0 ,  1) { (l, r) => match crate::schemata::at(1, 1) { 1 => l - r, _ => l + r } })]";
        let choice = "match crate::schemata::at(2, 1) { 1 => *l -= r, _ => *l += r };";
        let expected = format!("(match (2.0) {{ r => {{ let l = &mut ({index}); {choice} }} }})");
        assert_eq!(new.text, format!("fn f(x: &mut [f64]) {{ {expected} }}"));
    }

    /// Constants are computed by the compiler, which has no environment.
    #[test]
    fn a_constant_stays_as_it_is() {
        let source = "const N: usize = 1 + 2;";
        assert_eq!(instrumented(source, &[(Genre::BinaryOperator, "+", "-")]).text, source);
    }
}
