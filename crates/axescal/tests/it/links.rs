//! Links of the Markdown pages: files and anchors exist, and the site's SUMMARY.md has every page of docs.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// What a page offers to links, and the links that it has.
#[derive(Default)]
struct Page {
    anchors: BTreeSet<String>,
    links: Vec<String>,
}

/// The anchor that code hosts and mdBook make of a heading.
fn slug(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

fn parse(text: &str) -> Page {
    let mut page = Page::default();
    let mut seen = BTreeMap::<String, usize>::new();
    let mut heading: Option<String> = None;
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                page.links.push(dest_url.into_string());
            }
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::Text(text) | Event::Code(text) => {
                if let Some(heading) = &mut heading {
                    *heading += &text;
                }
            }
            Event::End(TagEnd::Heading(_)) => {
                let slug = slug(&heading.take().unwrap_or_default());
                let before = seen.entry(slug.clone()).or_default();
                page.anchors.insert(if *before == 0 { slug } else { format!("{slug}-{before}") });
                *before += 1;
            }
            _ => {}
        }
    }
    page
}

/// `a/b/../c` is `a/c`; a path that leaves the repository is none.
fn normal(path: &Path) -> Option<PathBuf> {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => normal.push(name),
            Component::ParentDir if normal.pop() => {}
            Component::CurDir => {}
            _ => return None,
        }
    }
    Some(normal)
}

/// The links of `pages` that lead nowhere. `exists` says whether a path of the repository is a file.
fn dead(pages: &BTreeMap<PathBuf, Page>, exists: impl Fn(&Path) -> bool) -> Vec<String> {
    let mut dead = Vec::new();
    for (path, page) in pages {
        for link in page.links.iter().filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => Some(path.clone()),
                _ => normal(&path.parent().unwrap_or(Path::new("")).join(file)),
            };
            let fault = match &target {
                Some(target) if exists(target) => {
                    let known = |page: &Page| page.anchors.contains(anchor);
                    (!anchor.is_empty() && !pages.get(target).is_some_and(known)).then_some("no such heading")
                }
                _ => Some("no such file"),
            };
            dead.extend(fault.map(|fault| format!("{}: {link}: {fault}", path.display())));
        }
    }
    dead
}

/// The Markdown files below a folder, by their paths from the root; what is built or hidden is passed over.
fn markdown(root: &Path, folder: &Path, found: &mut BTreeMap<PathBuf, Page>) {
    for entry in fs::read_dir(root.join(folder)).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = entry.file_name().into_string().expect("UTF-8");
        let path = folder.join(&name);
        if entry.file_type().expect("a type").is_dir() {
            if !name.starts_with('.') && name != "target" && name != "fixtures" {
                markdown(root, &path, found);
            }
        } else if name.ends_with(".md") {
            let text = fs::read_to_string(root.join(&path)).expect("a page");
            found.insert(path, parse(&text));
        }
    }
}

fn repository() -> (PathBuf, BTreeMap<PathBuf, Page>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages = BTreeMap::new();
    markdown(&root, Path::new(""), &mut pages);
    (root, pages)
}

#[test]
fn every_link_leads_somewhere() {
    let (root, pages) = repository();
    assert!(pages.values().map(|page| page.links.len()).sum::<usize>() > 100, "the pages have links");
    let dead = dead(&pages, |path| root.join(path).is_file());
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

/// The site has every page; links to files that are no pages lead to folders that `just site` copies.
#[test]
fn the_site_has_every_page() {
    let (root, pages) = repository();
    let listed: BTreeSet<PathBuf> = pages[Path::new("SUMMARY.md")].links.iter().map(PathBuf::from).collect();
    let absent: Vec<&PathBuf> =
        pages.keys().filter(|path| path.starts_with("docs") && !listed.contains(*path)).collect();
    assert!(absent.is_empty(), "SUMMARY.md lacks {absent:?}");
    let recipes = fs::read_to_string(root.join("justfile")).expect("the justfile");
    let copied = recipes
        .lines()
        .find(|line| line.contains("target/site/src") && line.contains("cp "))
        .expect("a copy");
    let copied: Vec<&str> = copied.split_whitespace().collect();
    for path in &listed {
        for link in pages[path].links.iter().filter(|link| !link.contains("://") && !link.starts_with('#')) {
            let file = link.split('#').next().unwrap_or_default();
            let target = normal(&path.parent().unwrap_or(Path::new("")).join(file)).expect("a path");
            let held = listed.contains(&target) || copied.iter().any(|copied| target.starts_with(copied));
            assert!(held, "{}: {link}: the site lacks {}", path.display(), target.display());
        }
    }
}

/// A dead link, a dead anchor and a path out of the repository are found; links that hold are not.
#[test]
fn dead_links_are_found() {
    let pages = BTreeMap::from([
        (
            "docs/a.md".into(),
            parse("# One `b` two\n\n[b](b.md#twice-1) [up](../README.md) [me](#one-b-two) ![](a.svg)\n"),
        ),
        (
            "docs/b.md".into(),
            parse("## Twice\n\n## Twice\n\n```\n[code](c.md)\n```\n\n[web](https://c.md)\n"),
        ),
        ("README.md".into(), parse("[c](docs/c.md) [b](docs/b.md#thrice) [out](../x.md) [folder](docs)\n")),
    ]);
    let found = dead(&pages, |path| path == Path::new("docs/a.svg") || pages.contains_key(path));
    let expected = [
        "docs/c.md: no such file",
        "docs/b.md#thrice: no such heading",
        "../x.md: no such file",
        "docs: no such file",
    ];
    assert_eq!(found, expected.map(|fault| format!("README.md: {fault}")));
}
