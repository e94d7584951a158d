"""Parts of the HTML pages of results: style, tables, pictures inside the page, atomic writing."""

import base64
import contextlib
import html
import io
import pathlib
import tempfile

from PIL import Image  # Matplotlib brings it

from rcr import __version__
from rcr._data import files

_STYLE = """
body { font: 15px/1.45 sans-serif; color: #222;
  max-width: 76em; margin: 1.2em auto; padding: 0 1em }
h1 { font-size: 22px; margin: 0.3em 0 } h2 { font-size: 18px }
p.lead { margin: 0.4em 0; max-width: 72em }
table { border-collapse: collapse; width: 100%; font-size: 13px }
th, td { border-top: 1px solid #ccc; padding: 4px 8px; text-align: left; vertical-align: top }
td.yes { background: #dff0d8 } td.no { background: #f6d5d2 } td.open { background: #eee }
small { color: #555 } figure { margin: 2em 0 }
img { max-width: 100%; height: auto } img.curve { max-height: 34em }
div.four { display: grid; grid-template-columns: repeat(4, 1fr); gap: 12px }
div.four figure { margin: 0.6em 0; font-size: 13px }
div.four img { height: 19em; width: 100%; object-fit: contain; object-position: bottom }
details { margin: 1em 0 } summary { cursor: pointer }
"""


def page(title, parts):
    """Return an HTML page with a title as its heading."""
    head = (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n<title>{title}</title>'
            f"<style>{_STYLE}</style></head><body>\n<h1>{title}</h1>")
    foot = f"<p><small>yade-rcr {__version__}</small></p></body></html>\n"
    return "\n".join([head, *parts, foot])


def image(path):
    """Return a picture as HTML; maps as WebP, since their PNG is large."""
    if "-" not in path.stem:
        return _image("curve", path.stem, "png", path.read_bytes())
    stream = io.BytesIO()
    Image.open(path).convert("RGB").save(stream, "webp", quality=80)
    return _image("map", path.stem, "webp", stream.getvalue())


def drawn(figure, name):
    """Return a Figure as HTML, without a file."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=200)
    return _image("curve", name, "png", stream.getvalue())


def _image(kind, name, media, data):
    source = f"data:image/{media};base64,{base64.b64encode(data).decode()}"
    return f"<img class='{kind}' alt='{html.escape(name)}' src='{source}'>"


def figure(name, pictures, caption):
    """Return pictures with a caption, which is HTML; `name` is the target of links."""
    images = "".join(map(image, pictures))
    return f"<figure id='{name}'>{images}<figcaption>{caption}</figcaption></figure>"


@contextlib.contextmanager
def scratch(out, begin=lambda: None):
    """Block that yields a folder; its files replace those of `out` at the end of the block.

    No file is replaced if the block raises. `begin` is called before the first one is replaced.
    """
    out = pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=files.PART, dir=out) as folder:
        folder = pathlib.Path(folder)
        yield folder
        begin()
        for path in sorted(folder.iterdir()):
            files.write(out / path.name, path.read_bytes())
