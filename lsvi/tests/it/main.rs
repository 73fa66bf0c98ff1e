//! What the library promises, on systems small enough to know the answer; one binary, so that they are linked once.

#[macro_use]
mod systems;

mod adaptive;
mod algebraic;
mod branches;
mod broken_line;
mod constraints;
mod counts;
mod coupled;
mod derivatives;
mod derivatives_of_motion;
mod events;
mod fields;
mod formulations;
mod high_order;
mod least_squares;
mod mechanics;
mod misuse;
mod open_closures;
mod outside;
mod recipes;
mod residuals;
mod seam;
mod separable;
mod structured;
mod trajectory;
mod units;
mod velocities;
mod work;
