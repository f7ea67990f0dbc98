//! The pages of the report: each answers the question in its title, and all link to each other.

use std::fmt::Write;

use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd, html};

use super::STYLE;
use super::plot::escape;

/// One page.
pub struct Sheet {
    /// The file without its ending.
    pub name: String,
    /// What it answers.
    pub question: String,
    pub body: String,
}

/// Pages of the documentation that belong to the report: file, question.
pub const DOCUMENTS: [(&str, &str); 5] = [
    ("extremes", "Which scenes at the limits are solved?"),
    ("needs", "What does a scene pay beside what it needs?"),
    ("certificate", "What does the certificate prove?"),
    ("planted", "Which faults does the certificate see?"),
    (
        "freefem",
        "How do scripts in FreeFEM solve the same scenes?",
    ),
];

/// All pages as files: (name, HTML). The first one is `index.html`.
pub fn files(sheets: &[Sheet]) -> Vec<(String, String)> {
    let page = |sheet: &Sheet| {
        let mut nav = String::from("<nav><p>");
        for (k, other) in sheets.iter().enumerate() {
            let dot = if k == 0 { "" } else { " · " };
            let question = escape(&other.question);
            let _ = match other.name == sheet.name {
                true => write!(nav, "{dot}<b>{question}</b>"),
                false => write!(nav, "{dot}<a href=\"{}.html\">{question}</a>", other.name),
            };
        }
        let question = escape(&sheet.question);
        let html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{question}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <h1>{question}</h1>\n{}{nav}</p></nav>\n</body>\n</html>\n",
            sheet.body
        );
        (format!("{}.html", sheet.name), html)
    };
    sheets.iter().map(page).collect()
}

/// A document in Markdown as the body of a page. Links to documents of the report lead to their pages; of other links within the project, the text is
/// kept.
pub fn document(text: &str) -> String {
    let mut is_kept = Vec::new();
    let mut is_title = false;
    let options = Options::ENABLE_TABLES;
    let events = Parser::new_ext(text, options).filter_map(|event| match event {
        // the question takes the place of the title
        Event::Start(Tag::Heading { level, .. }) if level as usize == 1 => {
            is_title = true;
            None
        }
        Event::End(TagEnd::Heading(level)) if level as usize == 1 => {
            is_title = false;
            None
        }
        _ if is_title => None,
        Event::Start(Tag::Link {
            link_type,
            dest_url,
            title,
            id,
        }) => {
            let own = target(&dest_url);
            is_kept.push(own.is_some());
            own.map(|own| {
                let dest_url = CowStr::from(own);
                Event::Start(Tag::Link {
                    link_type,
                    dest_url,
                    title,
                    id,
                })
            })
        }
        Event::End(TagEnd::Link) => is_kept
            .pop()
            .unwrap_or(false)
            .then_some(Event::End(TagEnd::Link)),
        Event::Start(Tag::Image { .. }) | Event::End(TagEnd::Image) => None,
        event => Some(event),
    });
    let mut body = String::new();
    html::push_html(&mut body, events);
    body.replace("<table>", "<div class=\"scroll\"><table>")
        .replace("</table>", "</table></div>")
}

/// Where a link of a document leads on these pages, if anywhere.
fn target(link: &str) -> Option<String> {
    if link.starts_with("https://") {
        return Some(link.to_string());
    }
    let file = link.split('#').next().unwrap_or_default();
    let name = file.strip_suffix(".md")?;
    let is_own = DOCUMENTS.iter().any(|(own, _)| *own == name);
    is_own.then(|| format!("{name}.html"))
}

/// What is broken on these pages: links that lead nowhere, plots without a point, pages without a question.
pub fn broken(files: &[(String, String)]) -> Vec<String> {
    let mut broken = Vec::new();
    for (name, html) in files {
        for link in between(html, "href=\"", "\"") {
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let there = match file {
                "" => Some(html),
                _ => files
                    .iter()
                    .find(|(own, _)| own == file)
                    .map(|(_, html)| html),
            };
            let is_there = there
                .is_some_and(|html| place.is_empty() || html.contains(&format!("id=\"{place}\"")));
            let is_elsewhere = link.starts_with("https://");
            if !is_there && !is_elsewhere {
                broken.push(format!("{name}: the link to {link} leads nowhere"));
            }
        }
        for plot in between(html, "<svg role=\"img\"", "</svg>") {
            if !plot.contains("<title>") {
                let label = between(plot, "aria-label=\"", "\"").next();
                let label = label.unwrap_or("without a label");
                broken.push(format!("{name}: the plot {label} has no point"));
            }
        }
        if !between(html, "<h1>", "</h1>").any(|title| title.ends_with('?')) {
            broken.push(format!("{name} has no question"));
        }
    }
    if files.iter().all(|(name, _)| name != "index.html") {
        broken.push("there is no index.html".to_string());
    }
    broken
}

/// The parts of a text between two marks.
fn between<'a>(text: &'a str, open: &'a str, close: &'a str) -> impl Iterator<Item = &'a str> {
    let parts = text.split(open).skip(1);
    parts.filter_map(move |part| part.split_once(close).map(|(inside, _)| inside))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(name: &str, question: &str, body: &str) -> Sheet {
        Sheet {
            name: name.into(),
            question: question.into(),
            body: body.into(),
        }
    }

    #[test]
    fn what_is_broken_is_told() {
        let sound = [
            sheet("index", "Which?", "<h2 id=\"a\">A</h2><a href=\"#a\">a</a>"),
            sheet("more", "What?", "<a href=\"index.html#a\">a</a>"),
        ];
        let none: [String; 0] = [];
        assert_eq!(broken(&files(&sound)), none);
        let plot = "<svg role=\"img\" aria-label=\"error\"></svg>";
        let bad = [
            sheet("more", "What", "<a href=\"none.html\">a</a>"),
            sheet(
                "other",
                "How?",
                &format!("<a href=\"more.html#b\">b</a>{plot}"),
            ),
        ];
        assert_eq!(
            broken(&files(&bad)),
            [
                "more.html: the link to none.html leads nowhere",
                "more.html has no question",
                "other.html: the link to more.html#b leads nowhere",
                "other.html: the plot error has no point",
                "there is no index.html",
            ]
        );
    }

    #[test]
    fn documents_keep_their_tables_and_their_links() {
        let text = "# Title\n\nSee [needs](needs.md#cost), [all](other.md), [web](https://example.org).\n\n| a | b |\n|---|---:|\n| 1 | 2 |\n";
        let body = document(text);
        assert!(!body.contains("Title"), "{body}");
        assert!(
            body.contains("<a href=\"needs.html\">needs</a>, all,"),
            "{body}"
        );
        assert!(body.contains("https://example.org"), "{body}");
        assert!(body.contains("<div class=\"scroll\"><table>"), "{body}");
    }

    /// The documents themselves, as they are.
    #[test]
    fn the_documents_are_whole_pages() {
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let mut sheets = vec![sheet("index", "Which?", "")];
        for (name, question) in DOCUMENTS {
            let text = std::fs::read_to_string(docs.join(format!("{name}.md"))).expect(name);
            sheets.push(sheet(name, question, &document(&text)));
        }
        let none: [String; 0] = [];
        assert_eq!(broken(&files(&sheets)), none);
    }
}
