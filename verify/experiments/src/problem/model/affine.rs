//! What a model's tensors are in its state: affine, or anything.

use std::collections::HashMap;

use diffsl::ast::{Ast, AstKind};
use diffsl::discretise::{DiscreteModel, Tensor};

/// What an expression is in a vector u.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// A number that depends on nothing but the inputs.
    Constant,
    /// A function of t.
    OfTime,
    /// A u + g(t) with constant A.
    Affine,
    /// Anything else.
    Other,
}

/// What a tensor of a model is in `variable`, its state or the rate of that, as far as the text shows it; t is of the kind `time`, and a
/// name that is not known, as of the other of the two, may be anything.
pub(super) fn kind_of(model: &DiscreteModel, tensor: &Tensor, variable: &Tensor, time: Kind) -> Kind {
    let mut known: HashMap<&str, Kind> = HashMap::from([("t", time), (variable.name(), Kind::Affine)]);
    let constants = model.input().into_iter().chain(model.constant_defns()).chain(model.input_dep_defns());
    for tensor in constants {
        known.insert(tensor.name(), Kind::Constant);
        known.extend(tensor.elmts().iter().filter_map(|block| block.name()).map(|name| (name, Kind::Constant)));
    }
    for block in variable.elmts() {
        known.extend(block.name().map(|name| (name, Kind::Affine)));
    }
    // Definitions come before their use.
    for tensor in model.time_dep_defns().iter().chain(model.state_dep_defns()) {
        let kind = kind_of_tensor(tensor, &known);
        known.insert(tensor.name(), kind);
        for block in tensor.elmts() {
            known.extend(block.name().map(|name| (name, kind)));
        }
    }
    kind_of_tensor(tensor, &known)
}

fn kind_of_tensor(tensor: &Tensor, known: &HashMap<&str, Kind>) -> Kind {
    tensor.elmts().iter().map(|block| kind(block.expr(), known)).max().unwrap_or(Kind::Constant)
}

/// What an expression is; a name that is not known is taken for a function of u.
fn kind(expression: &Ast, known: &HashMap<&str, Kind>) -> Kind {
    match &expression.kind {
        AstKind::Number(_) | AstKind::Integer(_) => Kind::Constant,
        AstKind::Name(name) => known.get(name.name).copied().unwrap_or(Kind::Other),
        AstKind::Index(index) => kind(&index.left, known),
        AstKind::Monop(signed) => kind(&signed.child, known),
        AstKind::Binop(binop) => {
            let (left, right) = (kind(&binop.left, known), kind(&binop.right, known));
            match binop.op {
                '+' | '-' => left.max(right),
                _ if left.max(right) <= Kind::OfTime => left.max(right),
                '*' if left.min(right) == Kind::Constant => left.max(right),
                '/' if right == Kind::Constant => left,
                _ => Kind::Other,
            }
        }
        AstKind::Call(call) => {
            let arguments = call.args.iter().map(|argument| kind(argument, known)).max();
            arguments.filter(|kind| *kind <= Kind::OfTime).unwrap_or(Kind::Other)
        }
        AstKind::CallArg(argument) => kind(&argument.expression, known),
        _ => Kind::Other,
    }
}
