//! Which of the concealed physics may be looked at when.

use sha2::{Digest, Sha256};

use crate::{kinds, outside};

/// A group of what is concealed.
///
/// The rule: everything in [`kinds::ALL`] and [`outside::ALL`] is `Develop`. Of everything else the first byte of the SHA-256 of
/// `name/form` decides: an even one is `Choose`, an odd one is `Score`. Nobody chooses a group by hand, and a new entry does not move the
/// others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Looked at case by case while the finder is worked on.
    Develop,
    /// For the choice between two versions of the finder, by their scores alone.
    Choose,
    /// For the last score, of the version that was chosen.
    Score,
}

/// The group of a name and form. What is outside the catalogue has a name alone: its form is empty.
pub fn of(name: &str, form: &str) -> Group {
    let kind = kinds::ALL.iter().any(|kind| kind.name == name && kind.form == form);
    let outside = outside::ALL.iter().any(|(own, _)| *own == name && form.is_empty());
    if kind || outside {
        return Group::Develop;
    }
    let digest = Sha256::digest(format!("{name}/{form}").as_bytes());
    if digest[0] % 2 == 0 { Group::Choose } else { Group::Score }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::{ALL, FURTHER};

    #[test]
    fn what_was_looked_at_stays_with_the_development() {
        assert!(ALL.iter().all(|kind| of(kind.name, kind.form) == Group::Develop));
        assert!(outside::ALL.iter().all(|(name, _)| of(name, "") == Group::Develop));
    }

    /// Both of the other groups have several entries, and names that the first thirty kinds do not have.
    #[test]
    fn neither_of_the_others_is_empty() {
        for group in [Group::Choose, Group::Score] {
            let own: Vec<_> = FURTHER.iter().filter(|kind| of(kind.name, kind.form) == group).collect();
            assert!(own.len() >= 8, "{group:?}: {}", own.len());
            let new = |name: &str| ALL.iter().all(|kind| kind.name != name);
            assert!(own.iter().any(|kind| new(kind.name)), "{group:?}");
        }
        assert!(FURTHER.iter().all(|kind| of(kind.name, kind.form) != Group::Develop));
    }
}
