"use strict";
// The place where a program is written: Monaco where the server has it, a plain text area elsewhere. Both have
// `text()`, `set(text)`, `mark(line, message)` with line 0 for no mark, and `focus()`.

function loadScript(address) {
  return new Promise((done, fail) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = done;
    script.onerror = () => fail(new Error(`${address} cannot be loaded`));
    document.head.append(script);
  });
}

async function loadMonaco(place) {
  const style = document.createElement("link");
  style.rel = "stylesheet";
  style.href = `${place.base}/editor/editor.main.css`;
  document.head.append(style);
  await loadScript(`${place.base}/loader.js`);
  require.config({ paths: { vs: place.base } });
  await new Promise((done, fail) => require(["vs/editor/editor.main"], done, fail));
  // Monaco's own way makes workers of scripts in the page, which this page does not allow.
  window.MonacoEnvironment = { getWorker: () => new Worker(place.worker, { type: "module" }) };
}

function withMonaco(area, text, onChange, onRun) {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const theme = () => (dark.matches ? "vs-dark" : "vs");
  const editor = monaco.editor.create(area, {
    value: text, language: "python", theme: theme(), automaticLayout: true, minimap: { enabled: false },
    scrollBeyondLastLine: false, fontSize: 14, tabSize: 4, insertSpaces: true, glyphMargin: true,
    quickSuggestions: false, accessibilitySupport: "auto",
  });
  dark.addEventListener("change", () => monaco.editor.setTheme(theme()));
  let isQuiet = false;
  editor.onDidChangeModelContent(() => { if (!isQuiet) onChange(); });
  editor.addCommand(monaco.KeyMod.CtrlCmd | monaco.KeyCode.Enter, onRun);
  const marks = editor.createDecorationsCollection();
  return {
    text: () => editor.getModel().getValue(monaco.editor.EndOfLinePreference.LF),
    set(newer) {
      const view = editor.saveViewState();
      isQuiet = true;
      editor.getModel().setValue(newer);
      isQuiet = false;
      editor.restoreViewState(view);
    },
    mark(line, message) {
      const last = editor.getModel().getLineCount();
      if (!line || line > last) { marks.clear(); return; }
      marks.set([{
        range: new monaco.Range(line, 1, line, 1),
        options: {
          isWholeLine: true, className: "error-line", linesDecorationsClassName: "error-sign",
          hoverMessage: { value: message.replace(/[^\w\s.,:;'"=+-]/g, "\\$&") },
        },
      }]);
      editor.revealLineInCenterIfOutsideViewport(line);
    },
    focus: () => editor.focus(),
  };
}

function withTextArea(area, text, onChange, onRun) {
  const field = document.createElement("textarea");
  field.className = "plain";
  field.spellcheck = false;
  field.setAttribute("aria-label", "Program");
  field.value = text;
  field.addEventListener("input", onChange);
  field.addEventListener("keydown", event => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) { event.preventDefault(); onRun(); }
    if (event.key === "Tab" && !event.shiftKey) {
      event.preventDefault();
      field.setRangeText("    ", field.selectionStart, field.selectionEnd, "end");
      onChange();
    }
  });
  area.replaceChildren(field);
  return {
    text: () => field.value,
    set(newer) {
      const [start, end] = [field.selectionStart, field.selectionEnd];
      field.value = newer;
      field.setSelectionRange(start, end);
    },
    mark(line) {
      if (!line) return;
      const lines = field.value.split("\n");
      if (line > lines.length) return;
      const start = lines.slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0);
      field.focus();
      field.setSelectionRange(start, start + lines[line - 1].length);
    },
    focus: () => field.focus(),
  };
}

async function makeEditing(place, area, text, onChange, onRun) {
  if (place.base) {
    try {
      await loadMonaco(place);
      return withMonaco(area, text, onChange, onRun);
    } catch (error) {
      trouble(`The editor cannot be loaded, so this is a plain one: ${error.message}`);
    }
  }
  return withTextArea(area, text, onChange, onRun);
}
