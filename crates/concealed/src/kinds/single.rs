//! One kind of effect that is concealed alone.

use crate::draw::Draw;
use crate::effect::Effect;
use crate::scene::{Campaign, SceneKind};

/// A kind of effect.
#[derive(Clone, Copy)]
pub struct Single {
    /// Its name in scores: the catalogue's.
    pub name: &'static str,
    /// Which of the forms of its physics it has, in a few words.
    pub form: &'static str,
    /// The recordings that show it.
    pub scene: SceneKind,
    /// Time from one row to the next, where it is not the scene's own.
    pub step_s: Option<f64>,
    /// Makes one.
    pub make: fn(&Campaign, &mut Draw) -> Effect,
}

/// The form of those in [`super::ALL`].
pub const FIRST: &str = "first";

/// The first form of a kind.
pub const fn single(
    name: &'static str,
    scene: SceneKind,
    make: fn(&Campaign, &mut Draw) -> Effect,
) -> Single {
    Single { name, form: FIRST, scene, step_s: None, make }
}

/// The same with a time from one row to the next of its own.
pub const fn stepped(mut single: Single, step_s: f64) -> Single {
    single.step_s = Some(step_s);
    single
}
