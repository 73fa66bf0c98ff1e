//! What the library promises, on systems small enough to know the answer; one binary, so that they are linked once.

mod adaptive;
mod branches;
mod constraints;
mod coupled;
mod fields;
mod formulations;
mod high_order;
mod least_squares;
mod mechanics;
mod misuse;
mod open_closures;
mod recipes;
mod seam;
mod separable;
mod structured;
mod systems;
mod trajectory;
