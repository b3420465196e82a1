
use super::*;

#[test]
fn sizes() {
    extern crate std;
    std::println!("{} {}", size_of::<NomadState>(), size_of::<NomadNode>());
}
