//! Coefficients as texts: `1/2 - sqrt(3)/6`, `0.2113248654`, `1/sqrt(3)*cos(pi/18) + 1/2`.

use dashu_float::FBig;
use dashu_ratio::RBig;

use super::real::{BITS, Float, Real};

/// Deepest nesting of brackets, signs and powers.
const DEPTH: u32 = 40;
/// Largest exponent, as of powers of ten.
const EXPONENT: i64 = 99;
/// Longest number in digits.
const DIGITS: usize = 200;
/// Largest value of a part of a coefficient; no method has any near it.
const LARGEST: f64 = 1e150;
/// Decimals with fewer places are numbers like 0.5 or 0.0625, printed in full; with more they have been rounded.
const EXACT_PLACES: u32 = 6;
/// With fewer places than this they rarely stand for anything else.
const DOUBTED: u32 = 3;
/// Trailing zeros that a printed decimal may have lost.
const DROPPED: u32 = 2;
/// A fraction with a larger denominator q stands for a number that it approximates to 1/q², as the fractions of a continued one do.
const APPROXIMANT: u64 = 10_000_000_000;
/// Significant digits of a double that is printed to be read back.
const DOUBLE: std::ops::RangeInclusive<f64> = 15.0..=17.0;

/// What is wrong with a coefficient, and where in its text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Malformed {
    /// Byte in the text.
    pub at: usize,
    /// What is wrong.
    pub reason: String,
}

/// A parsed text.
#[derive(Debug, Clone)]
pub(super) enum Expression {
    /// A number as its digits, and how many stand after the point where it has one.
    Number {
        value: RBig,
        places: Option<u32>,
    },
    Pi,
    /// z, where a coefficient may be a function.
    Variable {
        at: usize,
    },
    Negative(Box<Self>),
    Binary {
        operator: char,
        at: usize,
        left: Box<Self>,
        right: Box<Self>,
    },
    Function {
        name: Function,
        at: usize,
        argument: Box<Self>,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Function {
    Sqrt,
    Cbrt,
    Sin,
    Cos,
    Tan,
    Exp,
}

const FUNCTIONS: [(&str, Function); 6] = [
    ("sqrt", Function::Sqrt),
    ("cbrt", Function::Cbrt),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("exp", Function::Exp),
];

/// A value: exact where it is rational, and to the digits printed otherwise.
#[derive(Debug, Clone)]
pub(super) struct Value {
    pub exact: Option<RBig>,
    pub real: Real,
}

/// Which decimals have been rounded, and to how many places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rounding {
    places: Option<u32>,
    is_declared: bool,
    /// Places of the longest decimal, rounded or not.
    longest: Option<u32>,
    /// Whether there are fractions that stand for other numbers.
    approximates: bool,
}

impl Rounding {
    /// As a file declares it with `digits`, or as its longest decimal shows; decimals all shorter than six places are exact.
    pub(super) fn new(declared: Option<u32>, longest: Option<u32>) -> Self {
        let places = declared.or(longest.filter(|places| *places >= EXACT_PLACES));
        Self { places, is_declared: declared.is_some(), longest, approximates: false }
    }

    /// Of coefficients among which there are fractions that stand for other numbers.
    #[must_use]
    pub(super) fn with_approximants(self, approximates: bool) -> Self {
        Self { approximates, ..self }
    }

    /// In words.
    pub fn told(self) -> String {
        match self.places {
            Some(places) if self.is_declared => format!("decimals printed to {places} places"),
            Some(places) => format!("decimals rounded in their last place, the longest has {places}"),
            None if self.approximates => "fractions p/q with q above 10^10 taken for numbers within 1/q^2".into(),
            None => "coefficients taken as exact".into(),
        }
    }

    /// Where decimals are taken as exact that may be no more than rounded: what would say so.
    pub fn doubt(self) -> Option<String> {
        let places = self.longest.filter(|places| *places >= DOUBTED && self.places.is_none())?;
        Some(format!(
            "Decimals of {places} places are taken as exact; if they are rounded, the line `digits = {places}` says so."
        ))
    }

    /// Places after the point to which the decimals are printed; `None` where all are exact.
    pub fn places(self) -> Option<u32> {
        self.places
    }

    /// How far a decimal with so many places may be from what it was rounded from: half a unit in its last place, or in that
    /// of `digits`, whether more are printed or trailing zeros may have been dropped; no less than the rounding of a double where
    /// it has as many digits as one prints.
    fn radius(self, value: f64, places: u32) -> f64 {
        let half = |places: u32| 0.5 * 10_f64.powi(-(places as i32));
        match self.places {
            Some(printed) if self.is_declared && places + DROPPED >= printed => half(printed),
            Some(_) if !self.is_declared && places >= EXACT_PLACES => {
                let digits = f64::from(places) + value.abs().log10().floor() + 1.0;
                if DOUBLE.contains(&digits) { half(places).max(0.5 * f64::EPSILON * value.abs()) } else { half(places) }
            }
            _ => 0.0,
        }
    }
}

impl Expression {
    pub(super) fn parse(text: &str) -> Result<Self, Malformed> {
        let mut parser = Parser { text, at: 0, depth: 0 };
        let expression = parser.sum()?;
        match parser.peek() {
            None => Ok(expression),
            Some(found) => Err(parser.wrong(format!("`{found}` is not expected here"))),
        }
    }

    /// The longest decimal in it, in places after the point.
    pub(super) fn places(&self) -> Option<u32> {
        match self {
            Self::Number { places, .. } => *places,
            Self::Pi | Self::Variable { .. } => None,
            Self::Negative(inner) | Self::Function { argument: inner, .. } => inner.places(),
            Self::Binary { left, right, .. } => left.places().max(right.places()),
        }
    }

    /// Whether a fraction in it stands for another number.
    pub(super) fn approximates(&self) -> bool {
        match self {
            Self::Number { .. } | Self::Pi | Self::Variable { .. } => false,
            Self::Negative(inner) | Self::Function { argument: inner, .. } => inner.approximates(),
            Self::Binary { left, right, .. } => {
                self.approximant().is_some() || left.approximates() || right.approximates()
            }
        }
    }

    /// The denominator of a quotient of two whole numbers, where it is so large that nobody means the fraction itself.
    fn approximant(&self) -> Option<f64> {
        let Self::Binary { operator: '/', left, right, .. } = self else { return None };
        match (&**left, &**right) {
            (Self::Number { value: p, places: None }, Self::Number { value: q, places: None }) if *q != RBig::ZERO => {
                let quotient = p / q;
                let q = quotient.denominator();
                (*q > APPROXIMANT.into()).then(|| q.to_f64().value())
            }
            _ => None,
        }
    }

    /// The radicand of every square root of a whole number in it.
    pub(super) fn radicands(&self, out: &mut Vec<i64>) {
        match self {
            Self::Number { .. } | Self::Pi | Self::Variable { .. } => {}
            Self::Negative(inner) => inner.radicands(out),
            Self::Binary { left, right, .. } => {
                left.radicands(out);
                right.radicands(out);
            }
            Self::Function { name, argument, .. } => match (&**argument, name) {
                (Self::Number { value, .. }, Function::Sqrt) if value.is_int() => {
                    out.extend(i64::try_from(value.numerator().clone()));
                }
                _ => argument.radicands(out),
            },
        }
    }

    /// Whether z is in it.
    pub(super) fn is_function(&self) -> bool {
        match self {
            Self::Variable { .. } => true,
            Self::Number { .. } | Self::Pi => false,
            Self::Negative(inner) | Self::Function { argument: inner, .. } => inner.is_function(),
            Self::Binary { left, right, .. } => left.is_function() || right.is_function(),
        }
    }

    /// The same with a number for z.
    pub(super) fn at(&self, z: &RBig) -> Self {
        let inner = |part: &Self| Box::new(part.at(z));
        match self {
            Self::Variable { .. } => Self::Number { value: z.clone(), places: None },
            Self::Number { .. } | Self::Pi => self.clone(),
            Self::Negative(part) => Self::Negative(inner(part)),
            Self::Binary { operator, at, left, right } => {
                Self::Binary { operator: *operator, at: *at, left: inner(left), right: inner(right) }
            }
            Self::Function { name, at, argument } => Self::Function { name: *name, at: *at, argument: inner(argument) },
        }
    }

    pub(super) fn evaluate(&self, rounding: Rounding) -> Result<Value, Malformed> {
        let value = match self {
            Self::Number { value, places } => {
                // A zero is one, with however many places it is printed.
                let places = places.filter(|_| !value.is_zero());
                let radius = places.map_or(0.0, |places| rounding.radius(value.to_f64().value(), places));
                let real = Real::rational(value).widened(radius);
                Value { exact: (radius == 0.0).then(|| value.clone()), real }
            }
            Self::Variable { at } => {
                let reason = "`z` is not known here: only the coefficients of closures are functions".into();
                return Err(Malformed { at: *at, reason });
            }
            Self::Pi => Value { exact: None, real: Real::rounded(Float::pi(BITS), 0.0) },
            Self::Negative(inner) => {
                let inner = inner.evaluate(rounding)?;
                Value { exact: inner.exact.map(|x| -x), real: -&inner.real }
            }
            Self::Binary { operator, at, left, right } => {
                let (left, right) = (left.evaluate(rounding)?, right.evaluate(rounding)?);
                let value = binary(*operator, left, right).map_err(|reason| Malformed { at: *at, reason })?;
                match self.approximant() {
                    Some(q) => Value { exact: None, real: value.real.widened(q.powi(-2)) },
                    None => value,
                }
            }
            Self::Function { name, at, argument } => {
                let argument = argument.evaluate(rounding)?;
                let real = apply(*name, &argument.real).map_err(|reason| Malformed { at: *at, reason })?;
                Value { exact: None, real }
            }
        };
        if value.real.to_f64().abs() > LARGEST {
            return Err(Malformed { at: 0, reason: format!("{:e} is too large", value.real.to_f64()) });
        }
        Ok(value)
    }
}

fn binary(operator: char, left: Value, right: Value) -> Result<Value, String> {
    let exact = |f: fn(&RBig, &RBig) -> RBig| match (&left.exact, &right.exact) {
        (Some(x), Some(y)) => Some(f(x, y)),
        _ => None,
    };
    let (exact, real) = match operator {
        '+' => (exact(|x, y| x + y), &left.real + &right.real),
        '-' => (exact(|x, y| x - y), &left.real - &right.real),
        '*' => (exact(|x, y| x * y), &left.real * &right.real),
        '/' if right.real.may_be_zero() => return Err("division by zero".into()),
        '/' => (exact(|x, y| x / y), &left.real / &right.real),
        _ => return power(&left, &right),
    };
    // A rational is rounded once, however it was put together.
    Ok(Value { real: exact.as_ref().map_or(real, Real::rational), exact })
}

fn power(base: &Value, exponent: &Value) -> Result<Value, String> {
    let whole = exponent.exact.as_ref().filter(|x| x.is_int()).and_then(|x| i64::try_from(x.numerator().clone()).ok());
    let root = exponent.exact.as_ref().and_then(|x| match u8::try_from(x.denominator().clone()) {
        Ok(2) => Some(Function::Sqrt),
        Ok(3) => Some(Function::Cbrt),
        _ => None,
    });
    if let (Some(root), Some(exponent)) = (root, &exponent.exact) {
        let base = Value { exact: None, real: apply(root, &base.real)? };
        let exponent = RBig::from(exponent.numerator().clone());
        return power(&base, &Value { real: Real::rational(&exponent), exact: Some(exponent) });
    }
    let n = whole
        .filter(|n| n.abs() <= EXPONENT)
        .ok_or("powers are whole numbers from −99 to 99, or halves and thirds of them")?;
    if n < 0 && base.real.may_be_zero() {
        return Err("division by zero".into());
    }
    let mut real = Real::one();
    for _ in 0..n.unsigned_abs() {
        real = &real * &base.real;
        if real.to_f64().abs() > LARGEST {
            return Err("the power is too large".into());
        }
    }
    if n < 0 {
        if real.may_be_zero() {
            return Err("the power is too large".into());
        }
        real = &Real::one() / &real;
    }
    let exact = base.exact.as_ref().map(|x| x.pow(n as isize));
    Ok(Value { real: exact.as_ref().map_or(real, Real::rational), exact })
}

/// The function at the centre, and its slope times the radius.
fn apply(function: Function, x: &Real) -> Result<Real, String> {
    let (at, radius) = (x.to_f64(), x.radius());
    if function == Function::Sqrt && at < 0.0 {
        return Err(format!("the square root of {at} is not real"));
    }
    if at.abs() > 1e6 {
        return Err(format!("an argument of {at:e} is too large"));
    }
    let mid = x.mid();
    if at == 0.0 || at.abs() <= 2.0 * radius {
        return match function {
            Function::Cos => Ok(Real::one().widened(radius)),
            Function::Exp => Ok(Real::one().widened(radius.exp() - 1.0)),
            _ if radius == 0.0 => Ok(Real::zero()),
            _ => Err("its argument cannot be told from zero".into()),
        };
    }
    let (value, slope): (FBig<_, 2>, f64) = match function {
        Function::Sqrt => (mid.sqrt(), 1.0 / (at - radius).sqrt()),
        Function::Cbrt => (mid.nth_root(3), 1.0 / (at.abs() - radius).cbrt().powi(2)),
        Function::Sin => (mid.sin(), 1.0),
        Function::Cos => (mid.cos(), 1.0),
        Function::Exp if at > 100.0 => return Err(format!("exp({at:e}) is too large")),
        // Below 10⁻⁶⁰ of what it is added to, it is lost in the rounding.
        Function::Exp if at < -400.0 => return Ok(Real::zero().widened(1e-170)),
        Function::Exp => (mid.exp(), (at + radius).exp()),
        Function::Tan => {
            // A pole is as far away as |cos| at least. Half of that nearer the slope is four times as large at most.
            if mid.cos().to_f64().value().abs() <= 2.0 * radius {
                return Err("its argument cannot be told from a pole".into());
            }
            let value = mid.tan();
            let slope = 4.0 + 4.0 * value.to_f64().value().powi(2);
            (value, slope)
        }
    };
    Ok(Real::rounded(value, slope * radius))
}

/// Numerator and denominator of a fraction that is one character.
pub(super) fn vulgar(c: char) -> Option<(i8, u8)> {
    let known = [
        ('½', 1, 2),
        ('⅓', 1, 3),
        ('⅔', 2, 3),
        ('¼', 1, 4),
        ('¾', 3, 4),
        ('⅕', 1, 5),
        ('⅖', 2, 5),
        ('⅗', 3, 5),
        ('⅘', 4, 5),
        ('⅙', 1, 6),
        ('⅚', 5, 6),
        ('⅐', 1, 7),
        ('⅛', 1, 8),
        ('⅜', 3, 8),
        ('⅝', 5, 8),
        ('⅞', 7, 8),
        ('⅑', 1, 9),
        ('⅒', 1, 10),
    ];
    known.into_iter().find(|(written, ..)| *written == c).map(|(_, numerator, denominator)| (numerator, denominator))
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: u32,
}

impl Parser<'_> {
    fn wrong(&self, reason: impl Into<String>) -> Malformed {
        Malformed { at: self.at, reason: reason.into() }
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// The next character after blanks.
    fn peek(&mut self) -> Option<char> {
        self.at += self.rest().len() - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    fn take(&mut self, choices: &[char]) -> Option<char> {
        let found = self.peek().filter(|c| choices.contains(c))?;
        self.at += found.len_utf8();
        // A minus sign as it is typeset.
        Some(match found {
            '−' => '-',
            '·' | '×' => '*',
            other => other,
        })
    }

    fn deeper<T>(&mut self, parse: impl FnOnce(&mut Self) -> Result<T, Malformed>) -> Result<T, Malformed> {
        if self.depth == DEPTH {
            return Err(self.wrong("it is nested too deeply"));
        }
        self.depth += 1;
        let result = parse(self);
        self.depth -= 1;
        result
    }

    fn sum(&mut self) -> Result<Expression, Malformed> {
        self.chain(&['+', '-', '−'], Self::product)
    }

    fn product(&mut self) -> Result<Expression, Malformed> {
        self.chain(&['*', '/', '·', '×'], Self::run)
    }

    /// Factors without a sign between them, as in 7√6 or 2(1 + √3): one product, which no quotient may end in, as 1/2√3 would.
    fn run(&mut self) -> Result<Expression, Malformed> {
        let divides = self.text[..self.at].trim_end().ends_with('/');
        let mut left = self.factor()?;
        let begins = |rest: &str| {
            let functions = ["sqrt(", "cbrt(", "sin(", "cos(", "tan(", "exp("];
            rest.starts_with(['√', '(', 'π']) || ["pi"].iter().chain(&functions).any(|name| rest.starts_with(name))
        };
        while begins(self.rest()) {
            if divides {
                return Err(
                    self.wrong("a quotient that goes on without a sign may be read in two ways: brackets or `*` tell")
                );
            }
            let at = self.at;
            let right = self.power()?;
            left = Expression::Binary { operator: '*', at, left: Box::new(left), right: Box::new(right) };
        }
        Ok(left)
    }

    /// Operators of one precedence, the first operand on the left; `//` is the quotient of whole numbers of some languages.
    fn chain(
        &mut self,
        operators: &[char],
        part: fn(&mut Self) -> Result<Expression, Malformed>,
    ) -> Result<Expression, Malformed> {
        let (mut left, mut length) = (part(self)?, 0);
        while let (Some(operator), at) = (self.take(operators), self.at) {
            // The chain nests to the left, and is taken apart by recursion.
            length += 1;
            if length > 100 {
                return Err(self.wrong("it has too many terms"));
            }
            if operator == '/' && self.rest().starts_with('/') {
                self.at += 1;
            }
            let right = part(self)?;
            left = Expression::Binary { operator, at, left: Box::new(left), right: Box::new(right) };
        }
        Ok(left)
    }

    /// A sign binds weaker than a power: −2^2 = −4.
    fn factor(&mut self) -> Result<Expression, Malformed> {
        match self.take(&['+', '-', '−']) {
            Some('-') => self.deeper(Self::factor).map(|inner| Expression::Negative(Box::new(inner))),
            Some(_) => self.deeper(Self::factor),
            None => self.power(),
        }
    }

    fn power(&mut self) -> Result<Expression, Malformed> {
        let base = self.atom()?;
        self.peek();
        let length = ["^", "**"].iter().find(|sign| self.rest().starts_with(**sign)).map_or(0, |sign| sign.len());
        if length == 0 {
            return Ok(base);
        }
        self.at += length;
        let at = self.at;
        let exponent = self.deeper(Self::factor)?;
        Ok(Expression::Binary { operator: '^', at, left: Box::new(base), right: Box::new(exponent) })
    }

    fn atom(&mut self) -> Result<Expression, Malformed> {
        match self.peek() {
            None => Err(self.wrong("a number is missing")),
            Some('(') => self.bracket(),
            Some('√') => {
                let at = self.at;
                self.take(&['√']);
                let argument = Box::new(self.deeper(Self::atom)?);
                Ok(Expression::Function { name: Function::Sqrt, at, argument })
            }
            Some(c) if vulgar(c).is_some() => {
                self.at += c.len_utf8();
                let (numerator, denominator) = vulgar(c).unwrap_or((0, 1));
                Ok(Expression::Number { value: RBig::from_parts(numerator.into(), denominator.into()), places: None })
            }
            Some('π') => {
                self.take(&['π']);
                Ok(Expression::Pi)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            Some('\\') => Err(self.wrong(
                r"of LaTeX, \frac, \tfrac, \dfrac, \nicefrac and \sqrt are read in a table with `&` and `\\`, and no names",
            )),
            Some(c) => Err(self.wrong(format!("`{c}` is not expected here"))),
        }
    }

    fn bracket(&mut self) -> Result<Expression, Malformed> {
        let open = self.at;
        self.take(&['(']);
        let inner = self.deeper(Self::sum)?;
        match self.take(&[')']) {
            Some(_) => Ok(inner),
            None => Err(Malformed { at: open, reason: "this bracket does not close".into() }),
        }
    }

    fn name(&mut self) -> Result<Expression, Malformed> {
        let at = self.at;
        let length = self.rest().chars().take_while(char::is_ascii_alphanumeric).count();
        let name = &self.text[at..at + length];
        if name == "pi" {
            self.at += length;
            return Ok(Expression::Pi);
        }
        if name == "z" {
            self.at += length;
            return Ok(Expression::Variable { at });
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) else {
            let reason = format!("`{name}` is not known; there are sqrt, cbrt, sin, cos, tan, exp and pi");
            return Err(Malformed { at, reason });
        };
        self.at += length;
        if self.peek() != Some('(') {
            return Err(self.wrong(format!("`{name}` is followed by its argument in brackets")));
        }
        let argument = Box::new(self.bracket()?);
        Ok(Expression::Function { name: *function, at, argument })
    }

    fn number(&mut self) -> Result<Expression, Malformed> {
        let at = self.at;
        let bytes = self.text.as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit() || **b == b'_').count();
        let mut end = at + digits(at);
        let whole = self.text[at..end].replace('_', "");
        let mut fraction = None;
        if bytes.get(end) == Some(&b'.') {
            let length = digits(end + 1);
            fraction = Some(self.text[end + 1..end + 1 + length].replace('_', ""));
            end += 1 + length;
        }
        let part = fraction.clone().unwrap_or_default();
        let wrong = |reason: String| Malformed { at, reason };
        if whole.is_empty() && part.is_empty() {
            return Err(wrong("a number has digits".into()));
        }
        if whole.len() + part.len() > DIGITS {
            return Err(wrong(format!("numbers have at most {DIGITS} digits")));
        }
        let mut exponent = 0;
        if matches!(bytes.get(end), Some(b'e' | b'E' | b'd' | b'D')) {
            let signed = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let length = digits(signed);
            let text = self.text[end + 1..signed + length].replace('_', "");
            exponent = match text.parse::<i64>() {
                Ok(n) if n.abs() <= EXPONENT => n,
                _ => return Err(wrong(format!("the exponent `{text}` is no whole number from −99 to 99"))),
            };
            end = signed + length;
        }
        self.at = end;
        let mantissa: dashu_int::IBig = format!("{whole}{part}").parse().map_err(|_| wrong("no number".into()))?;
        let places = part.len() as i64 - exponent;
        let scale = RBig::from(10_u8).pow(-places as isize);
        let value = RBig::from(mantissa) * scale;
        let is_decimal = fraction.is_some() || exponent < 0;
        Ok(Expression::Number { value, places: is_decimal.then_some(places.max(0) as u32) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn exact(text: &str) -> String {
        let value = Expression::parse(text).expect(text).evaluate(Rounding::new(None, None)).expect(text);
        value.exact.expect("rational").to_string()
    }

    fn real(text: &str) -> Real {
        Expression::parse(text).expect(text).evaluate(Rounding::new(None, None)).expect(text).real
    }

    #[test]
    fn rationals_stay_exact_and_signs_bind_as_in_mathematics() {
        for (text, value) in [
            ("1/2 - 1/3*2", "-1/6"),
            ("-2^2", "-4"),
            ("2**3 ** 2", "512"),
            ("2^-1", "1/2"),
            ("-⅔ + ½", "-1/6"),
            ("−(1 + 2) / 6", "-1/2"),
            ("1/2/3", "1/6"),
            ("0.125e1", "5/4"),
            ("1_000", "1000"),
            (".5", "1/2"),
            ("2(1 + 2)/4", "3/2"),
        ] {
            assert_eq!(exact(text), value, "{text}");
        }
    }

    #[test]
    fn roots_and_angles_are_right_to_forty_digits() {
        // From tables of √3, and cos(π/18) = 0.98480775301220805936674302458952301367…
        for (text, digits) in [
            ("sqrt(3)", "1.732050807568877293527446341505872366943"),
            ("√3", "1.732050807568877293527446341505872366943"),
            ("3^(1/2)", "1.732050807568877293527446341505872366943"),
            ("2^(1/3)", "1.259921049894873164767210607278228350570"),
            ("cos(pi/18)", "0.9848077530122080593667430245895230136706"),
            ("cbrt(2)", "1.259921049894873164767210607278228350570"),
            ("sqrt(2)^-2", "0.5"),
            ("(2cos(pi/18) + 0)/2", "0.9848077530122080593667430245895230136706"),
            ("2 sin(2pi/9 + π/18)^2/2", "0.5868240888334651744258583133846573980001"),
        ] {
            let known = real(digits);
            assert!((&real(text) - &known).to_f64().abs() < 1e-38, "{text} = {}", real(text));
        }
        assert!((&(&real("sqrt(2)") * &real("sqrt(2)")) - &Real::from(2)).may_be_zero());
    }

    /// At 0.5123 and 1.5706, known to half of the last place, and below zero.
    #[test]
    fn functions_of_decimals_are_as_uncertain_as_their_ends_are_apart() {
        let of = |text: &str| Expression::parse(text).expect(text).evaluate(Rounding::new(Some(4), Some(4)));
        type Named = (&'static str, fn(f64) -> f64);
        let functions: [Named; 6] = [
            ("sqrt", f64::sqrt),
            ("cbrt", f64::cbrt),
            ("sin", f64::sin),
            ("cos", f64::cos),
            ("exp", f64::exp),
            ("tan", f64::tan),
        ];
        for (name, function) in functions {
            for at in [0.5123, 1.5706, -0.5123] {
                let Ok(value) = of(&format!("{name}({at})")) else {
                    assert!(name == "sqrt" && at < 0.0, "{name}({at})");
                    continue;
                };
                let (middle, radius) = (value.real.to_f64(), value.real.radius());
                let apart = [at - 5e-5, at + 5e-5].map(|end| (function(end) - middle).abs());
                assert!(apart.iter().all(|apart| *apart <= radius * (1.0 + 1e-9)), "{name}({at}): {apart:?}, {radius}");
                assert!(radius <= 5.001e-5 * (4.0 + 4.0 * at.tan().powi(2)) + 1e-15, "{name}({at}): {radius}");
            }
        }
        // π/2 is 1.570796: 1.5707 may be 4.6e-5 below it.
        assert!(of("tan(1.5707)").is_err_and(|error| error.reason.contains("a pole")));
    }

    /// 1/3 − 0.3333 may be zero, to half of the last place.
    #[test]
    fn functions_at_zero_are_exact_and_those_of_what_may_be_zero_are_one_or_refused() {
        for (text, value) in
            [("sqrt(0)", 0), ("cbrt(0)", 0), ("sin(0)", 0), ("tan(0)", 0), ("cos(0)", 1), ("exp(0)", 1)]
        {
            assert!((&real(text) - &Real::from(value)).is_zero(), "{text} = {}", real(text));
        }
        for (name, one) in
            [("sqrt", false), ("cbrt", false), ("sin", false), ("tan", false), ("cos", true), ("exp", true)]
        {
            let expression = Expression::parse(&format!("{name}(1/3 - 0.3333)")).expect(name);
            match expression.evaluate(Rounding::new(Some(4), Some(4))) {
                Ok(value) => {
                    assert!(one && (&value.real - &Real::one()).may_be_zero() && value.real.radius() > 4e-5, "{name}")
                }
                Err(error) => assert!(!one && error.reason.contains("told from zero"), "{name}: {}", error.reason),
            }
        }
    }

    #[test]
    fn decimals_are_uncertain_by_half_their_last_place() {
        let of = |rounding: Rounding, text: &str| {
            Expression::parse(text).expect(text).evaluate(rounding).expect(text).real.radius()
        };
        let radius = |text: &str| of(Rounding::new(None, Some(10)), text);
        assert!((radius("0.2113248654") / 5e-11 - 1.0).abs() < 1e-9);
        assert!((radius("0.211324865") / 5e-10 - 1.0).abs() < 1e-9, "each by its own last place");
        assert_eq!(radius("0.5"), 0.0);
        let declared = Rounding::new(Some(10), Some(10));
        assert!((of(declared, "0.211324865405") / 5e-11 - 1.0).abs() < 1e-9, "more digits than are meant");
        // 1767732205903/4055673282236 of Kennedy and Carpenter approximates a root of a cubic.
        let (exact, long) = (Rounding::new(None, None), 4_055_673_282_236_f64);
        assert!((of(exact, "1767732205903/4055673282236") * long * long - 1.0).abs() < 1e-9);
        assert!(of(exact, "-(5783161/8100000000)") < 1e-50);
        assert!((of(declared, "0.21132486") / 5e-11 - 1.0).abs() < 1e-9, "two trailing zeros dropped");
        // A double that lost its leading zeros to the exponent: 16 digits, 18 places.
        let double = of(Rounding::new(None, Some(18)), "0.008480655492356989");
        assert!((double / (0.5 * f64::EPSILON * 0.008480655492356989) - 1.0).abs() < 1e-9, "{double}");
        // No double has 18 digits.
        assert!((of(Rounding::new(None, Some(18)), "0.123456789012345678") / 5e-19 - 1.0).abs() < 1e-9);
        assert_eq!(Rounding::new(None, Some(3)).places(), None);
        assert_eq!(Rounding::new(Some(3), Some(3)).places(), Some(3));
    }

    #[test]
    fn mistakes_are_found_where_they_are() {
        for (text, at, reason) in [
            ("1/2 - sqr(3)", 6, "`sqr` is not known"),
            ("1/0", 2, "division by zero"),
            ("(1 + 2", 0, "does not close"),
            ("1 2", 2, "not expected"),
            ("nan", 0, "`nan` is not known"),
            ("sqrt(-1)", 0, "not real"),
            ("1 +", 3, "missing"),
            ("9^99^99", 5, "too large"),
            ("9^(1/5)", 2, "whole numbers"),
            ("1e999", 0, "exponent"),
            ("1e99*1e99", 0, "too large"),
            ("sin(2000000)", 0, "too large"),
            ("exp(101)", 0, "too large"),
            ("1 + &", 4, "`&` is not expected here"),
        ] {
            let found = Expression::parse(text).and_then(|e| e.evaluate(Rounding::new(None, None))).expect_err(text);
            assert!(found.reason.contains(reason), "{text}: {found:?}");
            assert!(found.at.abs_diff(at) <= 2, "{text}: {found:?}");
        }
        assert!(Expression::parse(&"(".repeat(100_000)).is_err());
        assert!(Expression::parse(&"-".repeat(100_000)).is_err());
        assert!(Expression::parse(&"1+".repeat(100_000)).is_err());
    }

    proptest! {
        #[test]
        fn no_text_makes_it_panic(text in "[-+*/^() .0-9eEsqrtcobinpae√π−_]{0,40}") {
            if let Ok(expression) = Expression::parse(&text) {
                let _ = expression.evaluate(Rounding::new(Some(8), None));
            }
        }

        #[test]
        fn any_text_at_all_is_read_or_refused(text in "\\PC{0,30}") {
            let _ = Expression::parse(&text);
        }

        #[test]
        fn rationals_print_and_read_back(n in -100_000_i64..100_000, d in 1_i64..100_000) {
            let text = format!("{n}/{d}");
            prop_assert_eq!(real(&text).simplest(), Some(exact(&text).parse().expect("rational")));
        }
    }

    /// 1767732205903/4055673282236 of Kennedy and Carpenter.
    #[test]
    fn fractions_that_stand_for_other_numbers_are_found_wherever_they_are() {
        let long = "1767732205903/4055673282236";
        let approximates = |text: &str| Expression::parse(text).expect(text).approximates();
        for text in [long.into(), format!("-({long})"), format!("1/2 + {long}"), format!("{long} + 1/2")] {
            assert!(approximates(&text), "{text}");
        }
        for text in ["1/2", "0.25/4055673282236", "pi", "1/0"] {
            assert!(!approximates(text), "{text}");
        }
        let told = |approximates: bool| Rounding::new(None, None).with_approximants(approximates).told();
        assert_eq!(told(true), "fractions p/q with q above 10^10 taken for numbers within 1/q^2");
        assert_eq!(told(false), "coefficients taken as exact");
    }

    #[test]
    fn radicands_are_whole_numbers_under_a_square_root() {
        let mut found = Vec::new();
        let text = "1/2 - sqrt(3)/6 + sqrt(1.5)*cbrt(5) + sqrt(2*sqrt(7))";
        Expression::parse(text).expect(text).radicands(&mut found);
        assert_eq!(found, [3, 7]);
    }

    #[test]
    fn zero_has_powers_that_are_not_negative() {
        assert_eq!((exact("0^0"), exact("0^2")), ("1".to_owned(), "0".to_owned()));
        let error = Expression::parse("0^-1").expect("well-formed").evaluate(Rounding::new(None, None));
        assert_eq!(error.expect_err("a pole").reason, "division by zero");
    }

    /// The slope of √x is 1/(2√x) and that of ∛x is 1/(3∛x²), above 4 and above 6 there.
    #[test]
    fn roots_of_small_numbers_are_as_uncertain_as_they_are_steep() {
        let x = 0.0123_f64;
        for (name, slope) in [("sqrt", 0.5 / x.sqrt()), ("cbrt", x.cbrt().powi(-2) / 3.0)] {
            let expression = Expression::parse(&format!("{name}({x})")).expect("well-formed");
            let radius = expression.evaluate(Rounding::new(Some(4), Some(4))).expect("positive").real.radius();
            assert!(radius > 5e-5 * slope && radius < 3.1 * 5e-5 * slope, "{name}: {radius:e}");
        }
    }

    /// e^{−1000} is no double.
    #[test]
    fn an_exponential_is_never_zero() {
        let tiny = real("exp(-1000)");
        assert!(tiny.may_be_zero() && !tiny.is_zero(), "{tiny:?}");
    }

    #[test]
    fn brackets_one_after_another_are_not_nested() {
        assert_eq!(exact(&vec!["(1)"; 50].join("+")), "50");
    }

    #[test]
    fn a_number_has_two_hundred_digits_at_most() {
        let text = |whole: usize, part: usize| format!("{}.{}", "0".repeat(whole), "3".repeat(part));
        for (whole, part, is_read) in [(100, 100, true), (1, 199, true), (100, 101, false), (1, 200, false)] {
            assert_eq!(Expression::parse(&text(whole, part)).is_ok(), is_read, "{whole} and {part}");
        }
    }

    #[test]
    fn places_are_those_after_the_point_as_it_is_moved_by_an_exponent() {
        for (text, places) in
            [("12", None), ("1e3", None), ("1e-3", Some(3)), ("1.25", Some(2)), ("1.25e1", Some(1)), ("1.5e3", Some(0))]
        {
            assert_eq!(Expression::parse(text).expect(text).places(), places, "{text}");
        }
    }
}
