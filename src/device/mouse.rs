//! The mouse finger: a spring-and-damper hand between the cursor and the HIP.
