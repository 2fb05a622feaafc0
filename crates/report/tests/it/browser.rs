//! Pages in headless Chromium: no console errors, every plot drawn, nothing that overlaps or hangs out, in
//! both themes and on a phone's width. Needs the browser: `just browser`.

use common::Document;
use report::{Options, html};
use serde::Deserialize;
use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::Command;

const CASES: [&str; 10] = [
    "coilcal/every-procedure/expected.json",
    "sensorcal/small/expected.json",
    "axescal/magsat/expected.json",
    "diffmag/turned-pair/expected.json",
    "diagnose/warm/expected.json",
    "correct/flight/expected.json",
    "ingest/logger/expected.json",
    "specs/calibrated/input.json",
    "report/observatory.json",
    "starcal/day/expected.json",
];

/// Widths of a desk and of a phone, CSS pixels.
const WIDTHS: [u32; 2] = [1280, 390];

/// Looks at the page and tells the page around it what is wrong, and how many plots there are.
const CHECK: &str = include_str!("browser.html");

/// What a reader does with a page: drags, turns the wheel, follows links, switches explanations off, saves.
const STEPS: &str = include_str!("interactive.html");

/// What one page told.
#[derive(Deserialize)]
struct Seen {
    page: String,
    width: u32,
    theme: String,
    drawings: usize,
    wrong: Vec<String>,
}

#[test]
#[ignore = "needs Chromium: just browser"]
fn pages_in_a_browser() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut drawings = HashMap::new();
    let options = Options { spec: Some(crate::magsat()), ..Options::default() };
    let texts = CASES.map(testkit::read_fixture).into_iter().chain([r#"{"fluxcal": 1}"#.to_string()]);
    for (number, text) in texts.enumerate() {
        let document = Document::parse(&text).expect("a document");
        let page = html::render(&report::run(&document, &options).expect("a page")).expect("HTML");
        let name = CASES.get(number).map_or("empty", |case| case);
        let name = format!("{}.html", name.replace('/', "-"));
        fs::write(folder.path().join(&name), page.replace("</body>", CHECK)).expect("written");
        drawings.insert(name, page.matches("<figure").count());
    }
    // Certificates as well, in full and with blanks; they have no plots, and are always light.
    for name in ["magsat.html", "blank.html"] {
        let page = testkit::read_fixture(&format!("certificate/{name}"));
        let page = page.replace("</body>", CHECK);
        for paper in ["A4", "letter"] {
            printed(folder.path(), &page.replacen("@page {", &format!("@page {{ size: {paper};"), 1));
        }
        fs::write(folder.path().join(name), page).expect("written");
        drawings.insert(name.into(), 0);
    }
    assert!(drawings.values().filter(|count| **count > 1).count() >= 7, "{drawings:?}");
    let mut wrong = Vec::new();
    for theme in ["light", "dark"] {
        let (all, console) = open(folder.path(), drawings.keys(), theme);
        assert_eq!(all.len(), WIDTHS.len() * drawings.len(), "{console:?}");
        wrong.extend(console);
        for seen in all {
            let Seen { page, width, .. } = &seen;
            let theme = if drawings[page] == 0 && page != "empty.html" { "light" } else { theme };
            assert!(WIDTHS.contains(width) && seen.theme == theme, "{page}: {width} px, {}", seen.theme);
            assert_eq!(seen.drawings, drawings[page], "plots of {page}");
            wrong.extend(seen.wrong.iter().map(|one| format!("{page}, {width} px, {theme}: {one}")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A certificate on paper: as many pages as the margin says, each with its number.
fn printed(folder: &Path, page: &str) {
    let [html, pdf] = ["print.html", "print.pdf"].map(|name| folder.join(name));
    fs::write(&html, page).expect("written");
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"])
        .arg(format!("--print-to-pdf={}", pdf.display()))
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}", html.display()))
        .output();
    assert!(output.expect("chromium").status.success());
    let text = Command::new("pdftotext")
        .arg(&pdf)
        .arg("-")
        .output()
        .expect("pdftotext; install it: apt-get install poppler-utils");
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    let pages: Vec<&str> = text.trim_end_matches('\u{c}').split('\u{c}').collect();
    assert!(pages.len() >= 3, "{}", pages.len());
    for (number, page) in pages.iter().enumerate() {
        let expected = format!("Page {} of {}", number + 1, pages.len());
        assert!(
            page.contains(&expected) && page.contains("Calibration certificate No."),
            "{expected}: {page}"
        );
    }
    assert!(pages.last().is_some_and(|page| page.contains("End of the calibration certificate")));
    // The end does not stand on a page of its own.
    assert!(pages.last().is_some_and(|page| page.contains("Signature")), "{pages:?}");
}

/// Every step that a reader can take on a page, in real time: pages that are drawn anew wait for frames.
#[test]
#[ignore = "needs Chromium: just browser"]
fn a_reader_uses_a_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut document = crate::fixture("diagnose/warm/expected.json");
    let series = document["diagnosis"][0]["series"][0].clone();
    let middle = series["x"][series["x"].as_array().expect("a list").len() / 2].clone();
    let place = &mut document["diagnosis"][0]["where"][0];
    place["recordings"] = serde_json::json!([series["recording"]]);
    place["time_s"] = serde_json::json!([middle, middle.as_f64().map(|middle| 1.2 * middle)]);
    let page = crate::html(&document);
    fs::write(folder.path().join("page.html"), page.replace("</body>", STEPS)).expect("written");
    for (theme, width) in [("light", 1280), ("dark", 390)] {
        let (seen, console) = used(folder.path(), theme, width);
        assert_eq!((seen.theme.as_str(), seen.width), (theme, width));
        assert!(seen.wrong.is_empty() && console.is_empty(), "{}\n{console:?}", seen.wrong.join("\n"));
    }
}

/// The page in a frame of this width; what it told comes by a port of this machine.
fn used(folder: &Path, theme: &str, width: u32) -> (Seen, Vec<String>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let all = format!(
        "<!DOCTYPE html><meta name='color-scheme' content='light dark'><title></title><body style='margin:0'><script>\
         onmessage = told => fetch('http://127.0.0.1:{port}', {{ method: 'POST', mode: 'no-cors', body: JSON.stringify(told.data) }});\
         </script><iframe src='page.html' width='{width}' height='800' style='border:0'></iframe>"
    );
    fs::write(folder.join("all.html"), all).expect("written");
    let log = folder.join("log");
    let mut browser = chromium(folder, theme)
        .args(["--window-size=1400,900", "--remote-debugging-port=0"])
        .arg(format!("file://{}", folder.join("all.html").display()))
        .stderr(File::create(&log).expect("a file"))
        .spawn()
        .expect("chromium; install it: apt-get install chromium");
    let (mut told, _) = listener.accept().expect("an answer");
    let (mut text, mut part) = (String::new(), [0; 4096]);
    let answer = loop {
        let read = told.read(&mut part).expect("an answer");
        text += &String::from_utf8_lossy(&part[..read]);
        let body = text.split_once("\r\n\r\n").map(|(_, body)| body);
        if let Some(seen) = body.and_then(|body| serde_json::from_str::<Seen>(body).ok()) {
            break seen;
        }
        assert!(read > 0, "{text}");
    };
    let _ = told.write_all(b"HTTP/1.1 204 No Content\r\n\r\n");
    browser.kill().expect("ended");
    browser.wait().expect("ended");
    let log = fs::read_to_string(log).expect("a log");
    (answer, log.lines().filter(|line| line.contains("CONSOLE")).map(str::to_string).collect())
}

/// The browser without a window.
fn chromium(folder: &Path, theme: &str) -> Command {
    let mut command = Command::new("chromium");
    command
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr"])
        .arg(format!("--blink-settings=preferredColorScheme={}", u8::from(theme == "light")))
        .arg(format!("--user-data-dir={}", folder.join("profile").display()));
    command
}

/// Opens the pages in frames of each width, since a window cannot be as narrow as a phone: what each told,
/// and the console.
fn open<'a>(folder: &Path, pages: impl Iterator<Item = &'a String>, theme: &str) -> (Vec<Seen>, Vec<String>) {
    let frame = |page: &String| {
        WIDTHS.map(|width| {
            format!("<iframe src='{page}' width='{width}' height='900' style='border:0'></iframe>")
        })
    };
    let frames: Vec<String> = pages.flat_map(frame).collect();
    let all = format!(
        "<!DOCTYPE html><meta name='color-scheme' content='light dark'><title></title><script>\
         const all = []; onmessage = told => {{ all.push(told.data); document.title = JSON.stringify(all); }};\
         </script>{}",
        frames.concat()
    );
    fs::write(folder.join("all.html"), all).expect("written");
    let output = chromium(folder, theme)
        .args(["--virtual-time-budget=20000", "--dump-dom"])
        .arg(format!("file://{}", folder.join("all.html").display()))
        .output()
        .unwrap_or_else(|error| panic!("chromium: {error}; install it: apt-get install chromium"));
    let dom = String::from_utf8_lossy(&output.stdout);
    let title =
        dom.split_once("<title>").and_then(|(_, rest)| rest.split_once("</title>")).expect("a title").0;
    let title = title.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let seen = serde_json::from_str(&title).unwrap_or_else(|error| panic!("{title}: {error}"));
    let console = String::from_utf8_lossy(&output.stderr);
    (seen, console.lines().filter(|line| line.contains("CONSOLE")).map(str::to_string).collect())
}
