//! Which of the concealed physics may be looked at when.

mod scored;

use sha2::{Digest, Sha256};

use crate::{kinds, outside};

/// A group of what is concealed.
///
/// The rule: everything in [`kinds::ALL`] and [`outside::ALL`] is `Develop`, and so is everything that a
/// published proof has scored and printed (`groups/scored.rs`). Of everything else the first byte of the
/// SHA-256 of `name/form` decides: an even one is `Choose`, an odd one is `Score`. Nobody chooses a group by
/// hand, and a new entry does not move the others.
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
    let scored =
        scored::KINDS.contains(&(name, form)) || (form.is_empty() && scored::OUTSIDE.contains(&name));
    if kind || outside || scored {
        return Group::Develop;
    }
    by_digest(name, form)
}

fn by_digest(name: &str, form: &str) -> Group {
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

    /// What was scored is still there under its name, and would have been in the group `Score`.
    #[test]
    fn what_was_scored_is_looked_at() {
        for (name, form) in scored::KINDS {
            assert!(FURTHER.iter().any(|kind| kind.name == name && kind.form == form), "{name}, {form}");
            assert_eq!((of(name, form), by_digest(name, form)), (Group::Develop, Group::Score));
        }
        for name in scored::OUTSIDE {
            assert!(outside::FURTHER.iter().any(|(own, _)| *own == name), "{name}");
            assert_eq!((of(name, ""), by_digest(name, "")), (Group::Develop, Group::Score));
        }
    }

    /// Both of the other groups have enough entries for a score, inside the catalogue and outside it, and
    /// names that the first thirty kinds do not have.
    #[test]
    fn neither_of_the_others_is_short() {
        for group in [Group::Choose, Group::Score] {
            let own: Vec<_> = FURTHER.iter().filter(|kind| of(kind.name, kind.form) == group).collect();
            assert!(own.len() >= 16, "{group:?}: {}", own.len());
            let new = |name: &str| ALL.iter().all(|kind| kind.name != name);
            assert!(own.iter().any(|kind| new(kind.name)), "{group:?}");
            let outside = outside::FURTHER.iter().filter(|(name, _)| of(name, "") == group).count();
            assert!(outside >= 8, "{group:?}: {outside} outside");
        }
    }
}
