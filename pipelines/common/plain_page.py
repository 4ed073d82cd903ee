"""What the pages of workflows share that show tables and pictures as they are."""

import html

PAGE = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
  body {{ max-width: 75rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif; color: #222 }}
  img {{ max-width: 100% }}
  figure {{ margin: 1rem 0 2rem }}
  figcaption {{ color: #666 }}
  table {{ border-collapse: collapse }}
  th, td {{ padding: 0.2rem 0.8rem; border-bottom: 1px solid #ddd; text-align: right }}
  th:first-child, td:first-child {{ text-align: left }}
</style>
<h1>{title}</h1>
<p>{about}</p>
{sections}
</html>
"""


def table(heading, rows):
    """A table with a heading row."""
    lines = ["".join(f"<th>{html.escape(cell)}</th>" for cell in heading)]
    lines += ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows]
    return "<table>\n" + "\n".join(f"<tr>{line}</tr>" for line in lines) + "\n</table>\n"


def figure(path, caption, more=""):
    """A picture that is a link to itself, with a caption that may go on in HTML."""
    picture = f'<a href="{path}"><img src="{path}" alt="{caption}"></a>'
    return f"<figure>{picture}<figcaption>{caption}{more}</figcaption></figure>\n"


def write_page(path, title, about, parts):
    """Write a page. about: a sentence on what it shows. parts: HTML by its heading."""
    sections = "".join(f"<h2>{heading}</h2>\n{part}" for heading, part in parts.items())
    path.write_text(PAGE.format(title=title, about=about, sections=sections), encoding="utf-8")
