//! A page that needs nothing beside itself, to read and to print: what score sheets and reports have in common.

use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("page.css");

/// What stands on a page.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    /// What sort of page it is, above the title.
    pub kind: &'a str,
    /// Its title.
    pub title: &'a str,
    /// Rules of its own, behind those of every page.
    pub style: &'a str,
    /// Its sections.
    pub body: Markup,
    /// What stands below them.
    pub footer: Markup,
}

impl Page<'_> {
    /// The whole document: no script, nothing that is loaded from elsewhere.
    pub fn document(&self) -> String {
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { "Dorsum: " (self.title) }
                    style { (PreEscaped(STYLE)) (PreEscaped(self.style)) }
                }
                body {
                    header { p.kind { (self.kind) } h1 { (self.title) } }
                    main { (self.body) }
                    footer { (self.footer) }
                }
            }
        };
        page.into_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_by_people_is_text_and_nothing_is_loaded() {
        let page = Page {
            kind: "Dorsum test",
            title: "<script>alert(1)</script>",
            style: ".own { color: red; }",
            body: html! { p { "a & b" } },
            footer: html! {},
        };
        let text = page.document();
        assert!(text.contains("&lt;script&gt;") && !text.contains("<script"));
        assert!(text.contains("a &amp; b") && text.contains(".own { color: red; }"));
        assert!(!text.contains("url(") && !text.contains("@import") && !text.contains("http"));
    }
}
