//! A condition on the figures, such as `relmse>1e-3`.

use std::fmt;
use std::str::FromStr;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Relation {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// A figure by its name, a relation and a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    name: String,
    relation: Relation,
    bound: f64,
}

/// Why a condition cannot be judged.
#[derive(Clone, Debug, PartialEq)]
pub enum Unmet {
    /// There is no figure of this name.
    Unknown(String),
    /// It has no value for these files.
    WithoutValue(String),
}

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = || {
            let at = text.find(['<', '>'])?;
            let (name, rest) = text.split_at(at);
            let (relation, bound) = match rest.as_bytes() {
                [b'<', b'=', ..] => (Relation::LessOrEqual, &rest[2..]),
                [b'>', b'=', ..] => (Relation::GreaterOrEqual, &rest[2..]),
                [b'<', ..] => (Relation::Less, &rest[1..]),
                _ => (Relation::Greater, &rest[1..]),
            };
            let bound: f64 = bound.trim().parse().ok()?;
            let name = name.trim();
            (!name.is_empty() && !bound.is_nan()).then(|| Self { name: name.to_owned(), relation, bound })
        };
        parsed().ok_or_else(|| {
            "expected a figure, one of < <= > >= and a number, for example 'relmse>1e-3' or 'p<0.01'"
                .to_owned()
        })
    }
}

impl Condition {
    /// The figure's value if the condition holds.
    pub fn holds(&self, figures: &[(String, Option<f64>)]) -> Result<Option<f64>, Unmet> {
        let found = figures.iter().find(|(name, _)| *name == self.name);
        let (_, value) = found.ok_or_else(|| Unmet::Unknown(self.name.clone()))?;
        let value = value.ok_or_else(|| Unmet::WithoutValue(self.name.clone()))?;
        let holds = match self.relation {
            Relation::Less => value < self.bound,
            Relation::LessOrEqual => value <= self.bound,
            Relation::Greater => value > self.bound,
            Relation::GreaterOrEqual => value >= self.bound,
        };
        // What is not a number keeps no promise.
        Ok((holds || value.is_nan()).then_some(value))
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let relation = match self.relation {
            Relation::Less => "<",
            Relation::LessOrEqual => "<=",
            Relation::Greater => ">",
            Relation::GreaterOrEqual => ">=",
        };
        write!(f, "{} {relation} {}", self.name, self.bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_read_and_judged() {
        let figures = [
            ("p".to_owned(), Some(0.01)),
            ("S0.550,0nm.rmse".to_owned(), Some(2.0)),
            ("flip".to_owned(), None),
        ];
        let holds = |text: &str| text.parse::<Condition>().unwrap().holds(&figures);
        assert_eq!(holds("p<0.01"), Ok(None));
        assert_eq!(holds("p <= 1e-2"), Ok(Some(0.01)));
        assert_eq!(holds("S0.550,0nm.rmse>=2"), Ok(Some(2.0)));
        assert_eq!(holds("p>0.01"), Ok(None));
        assert_eq!(holds("flip>0"), Err(Unmet::WithoutValue("flip".to_owned())));
        assert_eq!(holds("flop>0"), Err(Unmet::Unknown("flop".to_owned())));
        for wrong in ["", "p", "p=1", ">1", "p<x", "p<NaN", "p<1>2"] {
            assert!(wrong.parse::<Condition>().is_err(), "{wrong}");
        }
    }
}
