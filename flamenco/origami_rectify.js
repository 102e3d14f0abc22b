// Flat pages from folders of photos: a task for each document, then one for the summary.
//
// Copy this file into the folder `scripts` beside flamenco-manager. docs/batch.md says what the workers need.

const JOB_TYPE = {
    label: "Origami: Rectify Documents",
    description: "Make flat pages of folded sheets: one document for each folder of photos",
    settings: [
        { key: "photos", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Folder with a folder of photos for each document" },
        { key: "results", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Folder for the results: a folder for each document, and the summary" },
        { key: "paper", type: "string", default: "", visible: "submission",
          description: "Size of the paper: A4, Letter, 210x297 (mm), or 80 for a strip of that width; empty if unknown" },
        { key: "dpi", type: "int32", default: 0, propargs: { min: 0, max: 4800 }, visible: "submission",
          description: "Pixels per inch of the pages, which needs the size of the paper; 0 for as many as the photos have" },
        { key: "kind", type: "string", default: "sheet", visible: "submission",
          choices: ["sheet", "draft", "letter", "us_letter", "receipt", "archive"],
          description: "Kind of the documents" },
        { key: "light", type: "string", default: "paper", visible: "submission",
          choices: ["paper", "white", "as-photographed"],
          description: "Light on the pages" },
        { key: "colour", type: "string", default: "colour", visible: "submission",
          choices: ["colour", "grey", "black-and-white"],
          description: "Colours of the pages" },

        // Only Blender sees the folders, and a slash is in no name of one.
        { key: "documents", type: "string", required: true, visible: "web",
          eval: "'/'.join(sorted(p.name for p in set(abspath(settings.photos).iterdir()) - {abspath(settings.results)} " +
              "if p.is_dir() and not p.name.startswith('.')))",
          description: "Names of the documents' folders" },
    ],
};

const IN_BLENDER = ["-b", "--factory-startup", "--python-exit-code", "3", "-P"];

function compileJob(job) {
    const settings = job.settings;
    const photos = withoutSlash(settings.photos);
    const results = withoutSlash(settings.results);
    const names = settings.documents.split("/").filter((name) => name !== "");
    if (names.length === 0) {
        throw new Error("There is no folder of photos in " + photos + "; put each document's photos into a folder there.");
    }
    if (settings.dpi > 0 && !settings.paper && !["letter", "us_letter", "receipt"].includes(settings.kind)) {
        throw new Error("A resolution in dpi needs the size of the paper; fill in paper, for example A4.");
    }

    const summary = author.Task("summary", "blender");
    summary.addCommand(inBlender("workflow/scripts/summary.py", [results]));
    for (const name of names) {
        const task = author.Task(name, "blender");
        task.addCommand(inBlender("workflow/scripts/record.py", recorded(settings, photos + "/" + name, results + "/" + name)));
        job.addTask(task);
        summary.addDependency(task);
    }
    job.addTask(summary);
}

// The arguments of record.py. A document with unusable photos is no failure of the task: other workers could do no
// better and would be blocklisted; the summary lists it with its reason.
function recorded(settings, photos, results) {
    const rectify = [photos, "-o", results, "--resume"];
    rectify.push("--kind=" + settings.kind, "--light=" + settings.light, "--colour=" + settings.colour);
    if (settings.paper) {
        rectify.push("--paper=" + settings.paper);
    }
    if (settings.dpi > 0) {
        rectify.push("--dpi=" + settings.dpi);
    }
    const command = ["{blender}", ...IN_BLENDER, "{origami}/headless/rectify.py", "--", ...rectify];
    return [results, "document", "--succeed-if-explained", "--", ...command];
}

function inBlender(script, args) {
    return author.Command("exec", {
        exe: "{blender}",
        args: [...IN_BLENDER, "{origami}/" + script, "--", ...args],
    });
}

function withoutSlash(path) {
    return path.replace(/[\/\\]+$/, "");
}
