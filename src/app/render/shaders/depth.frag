// Depth alone: what is nearest of the skin, before it is laid over what lies below.
void main() {
}
