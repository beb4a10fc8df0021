fn main() {
    let _c = shaderc::Compiler::new().unwrap();
}
