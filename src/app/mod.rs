//! The workbench: window, dock, panels. The only module that knows a GUI library.
