def markdown(r, i): return ""
def html(r, i): return ""
