//! Powers with whole exponents as products.

use diffsl::ast::{Assignment, Ast, AstKind, Binop, Call, CallArg, DsModel, Monop, Tensor, TensorElmt};

/// The largest exponent that is written out.
const LARGEST: f64 = 16.0;

/// The model with `pow(x, n)` as x ⋯ x for whole n of up to 16 in size. DiffSL's derivative of a power has a term in ln x, which is no
/// number for x < 0, whatever the exponent.
pub(super) fn written_out<'a>(model: &DsModel<'a>) -> DsModel<'a> {
    let tensors = model.tensors.iter().map(|tensor| Box::new(rewritten(tensor))).collect();
    DsModel { has_inputs: model.has_inputs, tensors }
}

fn rewritten<'a>(expression: &Ast<'a>) -> Ast<'a> {
    let boxed = |part: &Ast<'a>| Box::new(rewritten(part));
    let kind = match &expression.kind {
        AstKind::Tensor(tensor) => {
            let elements = tensor.elmts().iter().map(rewritten).collect();
            AstKind::Tensor(Tensor::new(tensor.name(), tensor.indices().to_vec(), elements))
        }
        AstKind::TensorElmt(element) => {
            AstKind::TensorElmt(TensorElmt::new(boxed(&element.expr), element.indices.clone()))
        }
        AstKind::Assignment(set) => AstKind::Assignment(Assignment { name: set.name, expr: boxed(&set.expr) }),
        AstKind::Monop(signed) => AstKind::Monop(Monop { op: signed.op, child: boxed(&signed.child) }),
        AstKind::Binop(pair) => {
            AstKind::Binop(Binop { op: pair.op, left: boxed(&pair.left), right: boxed(&pair.right) })
        }
        AstKind::Call(call) => match &call.args[..] {
            [base, exponent] if call.fn_name == "pow" => match whole(exponent) {
                Some(n) => return power(rewritten(argument(base)), n),
                None => call_of(call),
            },
            _ => call_of(call),
        },
        AstKind::CallArg(argument) => {
            AstKind::CallArg(CallArg { name: argument.name, expression: boxed(&argument.expression) })
        }
        other => other.clone(),
    };
    Ast { kind, span: expression.span }
}

fn call_of<'a>(call: &Call<'a>) -> AstKind<'a> {
    let args = call.args.iter().map(|argument| Box::new(rewritten(argument))).collect();
    AstKind::Call(Call { fn_name: call.fn_name, args, is_tangent: call.is_tangent })
}

/// What an argument without a name is.
fn argument<'b, 'a>(expression: &'b Ast<'a>) -> &'b Ast<'a> {
    match &expression.kind {
        AstKind::CallArg(argument) if argument.name.is_none() => &argument.expression,
        _ => expression,
    }
}

/// The exponent that a literal states, if it is one to be written out.
fn whole(exponent: &Ast<'_>) -> Option<i32> {
    let n = super::constant(argument(exponent))?;
    (n.fract() == 0.0 && n != 0.0 && n.abs() <= LARGEST).then_some(n as i32)
}

fn power(base: Ast<'_>, n: i32) -> Ast<'_> {
    let binary = |op, left, right| Ast {
        span: base.span,
        kind: AstKind::Binop(Binop { op, left: Box::new(left), right: Box::new(right) }),
    };
    let product = (1..n.unsigned_abs()).fold(base.clone(), |product, _| binary('*', product, base.clone()));
    match n {
        1.. => product,
        _ => binary('/', Ast { kind: AstKind::Number(1.0), span: base.span }, product),
    }
}
