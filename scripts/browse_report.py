#!/usr/bin/env python3
"""Opens all pages of a report in headless Chromium, and tells what a browser shows wrong.

    scripts/browse_report.py [FOLDER] [--picture FILE.png] [--limit 60]

FOLDER is that of the pages (out/report-quick). The script follows links from index.html and tells: links and anchors
that lead nowhere, pages that no link reaches, pages without a heading or wider than their window, errors of scripts,
pictures that are missing, plots without points. It prints the sentences of the first page; their
seconds have to be in the tables of that page. --picture keeps a screenshot of the first page down to its last chart and the text below that.
What is wrong is printed one a line, and the exit code is then 1; it is 2 where nothing could be checked.
"""
import argparse
import html
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

FIRST = "index.html"
MISSING = "chromium is missing: install Debian's chromium, or run make report-browse"
# Nothing is fetched from elsewhere, and pictures can be read although they are files.
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--host-resolver-rules=MAP * ~NOTFOUND",
    "--allow-file-access-from-files", "--enable-logging=stderr",
)
# The window that pages have to fit in, and that of the picture.
WINDOW, PICTURE = 1200, 1400

BEFORE = """<script>
window.browsed = [];
addEventListener("error", ({target, message}) => {
  // pictures are measured below
  if (target instanceof HTMLImageElement) return;
  const source = target instanceof Element && (target.getAttribute("src") || target.getAttribute("href"));
  browsed.push(source ? `${source} does not load` : message);
}, true);
addEventListener("unhandledrejection", ({reason}) => browsed.push(String(reason)));
console.error = (...words) => browsed.push(words.join(" "));
</script>"""

AFTER = """<script>
for (const image of document.images) image.loading = "eager";
addEventListener("load", () => {
  const all = (chosen, within = document) => [...within.querySelectorAll(chosen)];
  const words = element => element.innerText.replace(/\\s+/g, " ").trim();
  const root = document.documentElement;

  // what sticks out most, unless something around it scrolls
  const sticksOut = () => {
    if (root.scrollWidth <= root.clientWidth) return null;
    const scrolls = element => element && element !== document.body &&
      (getComputedStyle(element).overflowX !== "visible" || scrolls(element.parentElement));
    const right = element => element.getBoundingClientRect().right;
    const free = all("body *").filter(element => !scrolls(element.parentElement));
    const most = free.reduce((a, b) => right(b) > right(a) ? b : a, document.body);
    return {width: root.scrollWidth, window: root.clientWidth, what: most.tagName.toLowerCase()};
  };

  const drawn = svg => {
    const axes = svg.getBoundingClientRect();
    const isShown = mark => {
      const box = mark.getBoundingClientRect(), style = getComputedStyle(mark);
      const x = box.left + box.width / 2, y = box.top + box.height / 2;
      return box.width + box.height > 0 && (style.fill !== "none" || style.stroke !== "none") &&
        mark.checkVisibility({opacityProperty: true, visibilityProperty: true}) &&
        axes.left - 1 < x && x < axes.right + 1 && axes.top - 1 < y && y < axes.bottom + 1;
    };
    // each point of a plot has a shape with a title, which the mouse finds
    const points = all("title", svg).map(title => title.parentElement).filter(shape => shape !== svg);
    const shown = points.filter(isShown).length;
    return {shown, points: points.length, unseen: points.length - shown};
  };

  // how many colours the inner part of a picture has, if that can be read
  const colours = image => {
    try {
      const canvas = Object.assign(document.createElement("canvas"), {width: 80, height: 80});
      const context = canvas.getContext("2d");
      context.drawImage(image, 0, 0, 80, 80);
      return new Set(new Uint32Array(context.getImageData(8, 8, 64, 64).data.buffer)).size;
    } catch { return null; }
  };

  const plot = element => {
    const {width, height} = element.getBoundingClientRect();
    const natural = [element.naturalWidth, element.naturalHeight];
    return element.tagName === "IMG"
      ? {source: element.getAttribute("src") || "without a source", width, height, natural, colours: colours(element)}
      : {name: element.getAttribute("aria-label") || "without a label", width, height, ...drawn(element)};
  };

  const plots = all("svg[role=img], img");
  const open = plots.filter(element => !element.closest("details:not([open])"));
  // with the text below a plot
  const whole = element => element.closest(".plots > div") || element;
  const bottoms = open.map(element => whole(element).getBoundingClientRect().bottom + scrollY);
  const folded = sticksOut();
  for (const details of all("details")) details.open = true;
  const findings = {
    errors: browsed,
    headings: all("h1").map(words).filter(Boolean),
    ids: all("[id], a[name]").flatMap(element => [element.id, element.getAttribute("name")]).filter(Boolean),
    links: all("a[href], area[href]").map(element => element.getAttribute("href")),
    plots: plots.map(plot),
    bottom: Math.max(0, ...bottoms),
    wide: folded || sticksOut(),
    texts: all("h3, p").map(element => [element.tagName, words(element)]),
    tables: all("table").map(table => ({
      title: table.closest("details")?.querySelector("summary")?.innerText.trim() || "",
      rows: all("tr", table).map(row => [...row.cells].map(words)),
    })),
  };
  const pre = Object.assign(document.createElement("pre"), {id: "findings", textContent: JSON.stringify(findings)});
  document.body.append(pre);
});
</script>"""


class Failure(Exception):
    """What a browser could not do."""


class Browser:
    """Chromium with a profile of its own, and a limit of seconds for each call."""

    def __init__(self, program, profile, limit):
        self.command = [program, *OPTIONS, f"--user-data-dir={profile}"]
        self.limit = limit

    def run(self, page, *options):
        """Calls the browser once; gives what it wrote and what it logged."""
        command = [*self.command, *options, page.absolute().as_uri()]
        streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        done = subprocess.Popen(command, text=True, errors="replace", start_new_session=True, **streams)
        try:
            output, log = done.communicate(timeout=self.limit)
        except BaseException as error:
            os.killpg(done.pid, signal.SIGKILL)
            done.wait()
            if isinstance(error, subprocess.TimeoutExpired):
                raise Failure(f"chromium was stopped after {self.limit:g} s") from None
            raise
        if done.returncode != 0:
            last = log.strip().splitlines()[-1:] or ["nothing"]
            raise Failure(f"chromium ended with code {done.returncode} and said: {last[0]}")
        return output, log

    def measure(self, page, width, *options):
        """Opens a copy that measures itself, and reads what it found."""
        dom, log = self.run(page, f"--window-size={width},900", *options, "--dump-dom")
        found = re.findall(r'<pre id="findings">(.*?)</pre>', dom, re.DOTALL)
        if not found:
            raise Failure("it never finished loading")
        findings = json.loads(html.unescape(found[-1]))
        # what the browser itself says of a page, such as of a path that it cannot read
        logged = re.findall(r':CONSOLE[:(]\d+\)?\] "(Error: .*?)", source:', log, re.DOTALL)
        findings["errors"] += [text for text in logged if text not in findings["errors"]]
        return findings

    def screenshot(self, page, height, kept):
        """Keeps the upper part of a page as a picture; gives its width and height."""
        self.run(page, "--hide-scrollbars", f"--window-size={PICTURE},{height}", f"--screenshot={kept}")
        head = kept.read_bytes()[:24] if kept.exists() else b""
        if len(head) < 24:
            raise Failure("chromium wrote no picture")
        return struct.unpack(">II", head[16:24])


def instrumented(text):
    """The text of a page with both scripts."""
    head = re.search(r"<head(\s[^>]*)?>", text, re.IGNORECASE) or re.search(r"<!doctype[^>]*>", text, re.IGNORECASE)
    place = head.end() if head else 0
    return text[:place] + BEFORE + text[place:] + AFTER


def mirror(folder, copy):
    """Rebuilds a folder of links to its files; pages become copies that measure themselves."""
    copy.mkdir()
    for entry in folder.iterdir():
        if entry.suffix == ".html" and entry.is_file():
            # what is no UTF-8 stays what it is
            text = entry.read_text(encoding="utf-8", errors="surrogateescape")
            (copy / entry.name).write_text(instrumented(text), encoding="utf-8", errors="surrogateescape")
        elif entry.is_dir() and any(entry.rglob("*.html")):
            mirror(entry, copy / entry.name)
        else:
            (copy / entry.name).symlink_to(entry.absolute())


def place(page, link):
    """The file within the folder that a link of a page leads to, and its anchor; None for links to elsewhere."""
    parts = urlsplit(link)
    if parts.scheme not in ("", "file"):
        return None
    path = unquote(parts.path)
    if parts.scheme or parts.netloc or path.startswith("/"):
        return "..", ""
    file = os.path.normpath(PurePosixPath(page).parent / path) if path else page
    return file, unquote(parts.fragment)


class Report:
    """A folder of pages, and what is wrong with them."""

    def __init__(self, folder, copy, browser):
        self.folder, self.copy, self.browser = folder, copy, browser
        self.pages = {}
        self.links = []
        self.pictures = {}
        self.wrong = []
        self.sentences = 0

    def tell(self, page, text):
        """Keeps a finding once."""
        line = f"{page}: {text}"
        if line not in self.wrong:
            self.wrong.append(line)

    def follow(self):
        """Opens all pages that links reach, the first one first."""
        waiting = [FIRST]
        while waiting:
            page = waiting.pop(0)
            if page in self.pages:
                continue
            try:
                self.pages[page] = self.browser.measure(self.copy / page, WINDOW)
            except Failure as failure:
                self.pages[page] = None
                self.tell(page, f"the page does not load: {failure}")
                continue
            for link in self.pages[page]["links"]:
                target = place(page, link)
                if target is None:
                    continue
                self.links.append((page, link, *target))
                file = target[0]
                if file.endswith(".html") and not file.startswith("..") and (self.folder / file).is_file():
                    waiting.append(file)

    def check_links(self):
        """Tells links and anchors that lead nowhere, and pages that no link reaches."""
        for page, link, file, anchor in self.links:
            if file.startswith(".."):
                self.tell(page, f"the link to {link} leads out of the folder")
            elif not (self.folder / file).is_file():
                self.tell(page, f"the link to {link} leads nowhere")
            elif anchor and self.pages.get(file) and anchor not in self.pages[file]["ids"]:
                self.tell(page, f"the link to {link} leads nowhere: {file} has no such anchor")
        for file in sorted(self.folder.rglob("*.html")):
            name = file.relative_to(self.folder).as_posix()
            if name not in self.pages:
                self.tell(name, "no link leads to this page")

    def check_page(self, page, findings):
        """Tells what is wrong on a page by itself."""
        if not findings["headings"]:
            self.tell(page, "the page has no heading <h1>")
        for error in findings["errors"]:
            self.tell(page, f"error in the browser: {' '.join(error.split())}")
        if wide := findings["wide"]:
            size = f"{wide['width']} px wide in a window of {wide['window']} px"
            self.tell(page, f"the page is {size}: <{wide['what']}> sticks out")
        for number, plot in enumerate(findings["plots"], 1):
            self.check_plot(page, number, plot)

    def check_plot(self, page, number, plot):
        """Tells a plot without points, and a picture that is missing or empty."""
        if "source" not in plot:
            self.check_marks(page, f"plot {number} “{plot['name']}”", plot)
        elif min(plot["natural"]) == 0:
            self.tell(page, f"the picture {plot['source']} is missing")
        elif min(plot["width"], plot["height"]) == 0:
            self.tell(page, f"the picture {plot['source']} takes no space")
        elif plot["colours"] == 1:
            self.tell(page, f"the picture {plot['source']} is empty")
        elif target := place(page, plot["source"]):
            file = self.copy / target[0]
            if file.suffix == ".svg" and file.is_file():
                self.check_drawing(page, plot["source"], file)

    def check_marks(self, page, name, plot):
        """Tells a plot that has no points, or points that nobody sees."""
        if min(plot["width"], plot["height"]) == 0:
            self.tell(page, f"{name} takes no space")
        elif plot["shown"] == 0:
            self.tell(page, f"{name} is empty: no point is seen")
        elif plot["unseen"] > 0:
            self.tell(page, f"{name}: of its {plot['points']} points, {plot['unseen']} are not seen")

    def check_drawing(self, page, source, file):
        """Opens the file of a picture as a plot of a page, and tells what is wrong with it."""
        if file not in self.pictures:
            text = re.sub(r"<svg\b", '<svg role="img"', file.read_text(encoding="utf-8"), count=1)
            text = re.sub(r"^.*?(?=<svg)", "", text, count=1, flags=re.DOTALL)
            alone = self.copy.parent / f"picture_{len(self.pictures)}.html"
            page_of_it = f'<!DOCTYPE html><meta charset="utf-8"><body>{text}'
            alone.write_text(instrumented(page_of_it), encoding="utf-8")
            try:
                self.pictures[file] = self.browser.measure(alone, WINDOW)["plots"][0]
            except Failure as failure:
                self.pictures[file] = None
                self.tell(page, f"the picture {source} does not load: {failure}")
        if self.pictures[file]:
            self.check_marks(page, f"the picture {source}", self.pictures[file])

    def read_sentences(self):
        """Prints the sentences of the first page under their charts, and tells each one that its tables do not have."""
        findings = self.pages[FIRST]
        charts = {}
        chart = None
        for tag, text in findings["texts"]:
            if tag == "H3":
                chart = text
                charts[chart] = 0
                print(chart)
            elif text.startswith(("For ", "No program")):
                print(f"  {text}")
                self.sentences += 1
                if chart is not None:
                    charts[chart] += 1
                self.check_sentence(chart or "", text, findings["tables"])
        if not charts:
            self.tell(FIRST, "the page has no chart <h3>")
        for chart, count in charts.items():
            if count == 0:
                self.tell(FIRST, f"the chart “{chart}” has no sentence")

    def check_sentence(self, chart, text, tables):
        """Tells seconds of a sentence that no run in the chart's table has, or none of a program that it names."""
        own = [table for table in tables if chart and table["title"].endswith(chart)] or tables
        runs = [run for table in own for run in seconds(table["rows"])]
        numbers = re.findall(r"(?<![\d.])\d+(?:\.\d+)?(?=\s+s\b)", text)
        if not numbers and text.startswith("For "):
            self.tell(FIRST, f"a sentence has no seconds: {text}")
        for number in numbers:
            programs = [program for shown, program in runs if shown == f"{float(number):.2f}"]
            if not programs:
                self.tell(FIRST, f"{number} s is not in the table of all runs: {text}")
            elif not any(program in text for program in programs):
                self.tell(FIRST, f"{number} s is that of a run of {', '.join(sorted(set(programs)))}: {text}")

    def picture(self, file):
        """Keeps the first page down to its last chart as a picture, and tells its size."""
        bottom = self.browser.measure(self.copy / FIRST, PICTURE, "--hide-scrollbars")["bottom"]
        if bottom == 0:
            raise Failure("the first page has no chart")
        kept = self.copy.with_name("screenshot.png")
        size = self.browser.screenshot(self.folder / FIRST, round(bottom) + 24, kept)
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.move(kept, file)
        return size


def seconds(rows):
    """The seconds of each run of a table as they are shown, with the program, if the table has such columns."""
    head = rows[0] if rows else []
    columns = [k for k, title in enumerate(head) if title.endswith("(s)")]
    program = head.index("program") if "program" in head else None
    for row in rows[1:]:
        if len(row) == len(head):
            yield from ((row[k], "" if program is None else row[program]) for k in columns)


def main():
    """Reads arguments, checks a report, and prints what is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out/report-quick"), help="where the pages are")
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help="keep a screenshot of the first page")
    parser.add_argument("--limit", type=float, default=60, metavar="SECONDS", help="of each call of chromium (60)")
    arguments = parser.parse_args()
    program = shutil.which("chromium")
    if program is None:
        print(MISSING, file=sys.stderr)
        return 2
    if not (arguments.folder / FIRST).is_file():
        print(f"{arguments.folder} has no {FIRST}: run make report-quick, or name another folder", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="browse_report_", ignore_cleanup_errors=True) as own:
        copy = Path(own) / "pages"
        mirror(arguments.folder, copy)
        report = Report(arguments.folder, copy, Browser(program, Path(own) / "profile", arguments.limit))
        report.follow()
        report.check_links()
        for page, findings in report.pages.items():
            if findings:
                report.check_page(page, findings)
        if report.pages[FIRST]:
            report.read_sentences()
        if arguments.picture:
            try:
                size = report.picture(arguments.picture)
                print(f"{arguments.picture}: {size[0]} × {size[1]} pixels")
            except (Failure, OSError) as failure:
                report.tell(FIRST, f"there is no picture of the page: {failure}")
        if report.wrong:
            print("\n".join(report.wrong))
            return 1
        plots = sum(len(findings["plots"]) for findings in report.pages.values())
        read = f"{len(report.pages)} pages, {len(report.links)} links, {plots} plots, {report.sentences} sentences"
        print(f"{read}: nothing is wrong")
        return 0


if __name__ == "__main__":
    sys.exit(main())
