//! What recorded sessions tell: measures of one session, differences between two, agreement and groups of many.
