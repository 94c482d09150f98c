"""sentences.py WORDS PAGE...: fails where more than half of a page's prose stands in sentences of more than WORDS words.

That is the median of the sentences, each counted as often as it has words: short ones cannot hide long ones. Headings, tables, code,
pictures and comments do not count. A sentence ends with . ! or ? before a capital, a digit or code, and with its paragraph or list item.
"""

import pathlib
import re
import statistics
import sys

ITEM = re.compile(r"^\s*(?:[-*]|\d+\.)\s+")
END = re.compile(r"(?<!e\.g\.)(?<=[.!?])[*)\"]*\s+(?=[\"(*\[]*(?:`|[A-Z0-9]))")
NO_PROSE = ("#", "|", "![")


def paragraphs(text):
    text = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    words, blank = [], True
    for line in [*text.splitlines(), ""]:
        code = blank and line.startswith("    ") and not ITEM.match(line)
        blank = not line.strip() or code
        prose = bool(line.strip()) and not code and not line.startswith(NO_PROSE)
        if words and (not prose or ITEM.match(line)):
            yield " ".join(words)
            words = []
        if prose:
            words.append(ITEM.sub("", line).strip())


def sentences(text):
    for paragraph in paragraphs(text):
        for sentence in END.split(re.sub(r"\]\([^)]*\)", "]", paragraph)):
            count = sum(bool(re.search(r"\w", word)) for word in sentence.split())
            if count:
                yield count, sentence


def main():
    limit, failed = int(sys.argv[1]), False
    for page in map(pathlib.Path, sys.argv[2:]):
        found = sorted(sentences(page.read_text(encoding="utf-8")), reverse=True)
        median = statistics.median(count for count, _ in found for _ in range(count))
        print(f"{page}: half of the words stand in sentences of at most {median:g} words, {limit} allowed")
        if median > limit:
            failed = True
            print(*(f"  {count} words: {sentence}" for count, sentence in found[:5]), sep="\n")
    sys.exit(failed)


if __name__ == "__main__":
    main()
