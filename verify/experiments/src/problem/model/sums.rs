//! Addends that DiffSL adds again and again: an index that is not on the left is summed over the whole right-hand side.

use diffsl::ast::{Ast, AstKind, DsModel};

/// An addend without an index that another one of its sum is summed over.
pub(super) struct Repeated {
    /// Its byte in the text, 0 where that is not known.
    pub(super) at: usize,
    pub(super) index: char,
}

/// The first addend that is added once for each value of an index of another.
pub(super) fn repeated(model: &DsModel<'_>) -> Option<Repeated> {
    let tensors = model.tensors.iter().filter_map(|tensor| match &tensor.kind {
        AstKind::Tensor(tensor) => Some(tensor),
        _ => None,
    });
    tensors.flat_map(|tensor| tensor.elmts().iter().map(|element| (tensor.indices(), element))).find_map(
        |(left, element)| {
            let AstKind::TensorElmt(element) = &element.kind else { return None };
            let mut all = Vec::new();
            addends(&element.expr, &mut all);
            element.expr.get_indices().into_iter().find_map(|index| {
                let lacks = |addend: &&&Ast<'_>| !addend.get_indices().contains(&index);
                let without = all.iter().find(lacks).filter(|_| !left.contains(&index))?;
                Some(Repeated { at: without.span.map_or(0, |span| span.pos_start), index })
            })
        },
    )
}

fn addends<'b, 'a>(expression: &'b Ast<'a>, out: &mut Vec<&'b Ast<'a>>) {
    match &expression.kind {
        AstKind::Binop(pair) if matches!(pair.op, '+' | '-') => {
            addends(&pair.left, out);
            addends(&pair.right, out);
        }
        AstKind::Monop(signed) => addends(&signed.child, out),
        AstKind::Assignment(set) => addends(&set.expr, out),
        _ => out.push(expression),
    }
}

#[cfg(test)]
mod tests {
    use diffsl::parser::parse_ds_string;

    #[test]
    fn an_addend_without_an_index_that_another_is_summed_over_is_named() {
        let found = |f: &str| {
            let text = format!("a_ij {{ (0:2, 0:2): 1.0 }} k {{ 2 }} u_i {{ (0:2): x = 1 }} F_i {{ {f} }}");
            let model = parse_ds_string(&text).expect("it reads");
            super::repeated(&model).map(|found| (text[found.at..].chars().next(), found.index))
        };
        assert_eq!(found("a_ij * u_j + u_i"), Some((Some('u'), 'j')));
        assert_eq!(found("a_ij * u_j - 1.0"), Some((Some('1'), 'j')));
        assert_eq!(found("k - a_ij * u_j"), Some((Some('k'), 'j')));
        assert_eq!(found("-(a_ij * u_j + k)"), Some((Some('k'), 'j')));
        for right in ["a_ij * u_j", "a_ij * (u_j - u_i)", "k * u_i + 1.0", "a_ij * u_j + 2 * a_ij * u_j"] {
            assert_eq!(found(right), None, "{right}");
        }
    }
}
