//! Warnings at the end of an error, so that none is lost with the model.

use std::fmt;

/// So many warnings are shown; the others are counted.
const SHOWN: usize = 4;

/// Shows warnings after a sentence: nothing if there are none.
pub(crate) struct Also<'a>(pub(crate) &'a [String]);

impl fmt::Display for Also<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (shown, others) = self.0.split_at(self.0.len().min(SHOWN));
        for (i, warning) in shown.iter().enumerate() {
            write!(f, "{}{warning}", if i == 0 { " Also: " } else { "; " })?;
        }
        match others.len() {
            0 => Ok(()),
            count => write!(f, "; and {count} more"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_warnings_are_shown_and_many_counted() {
        let show = |count: usize| {
            let warnings: Vec<_> = (0..count).map(|i| format!("w{i}")).collect();
            format!("None.{}", Also(&warnings))
        };
        assert_eq!(show(0), "None.");
        assert_eq!(show(1), "None. Also: w0");
        assert_eq!(show(4), "None. Also: w0; w1; w2; w3");
        assert_eq!(show(6), "None. Also: w0; w1; w2; w3; and 2 more");
    }
}
