# From photos to the page, in three rules, each of which stops after its own stages of headless/rectify.py.
#
# The outputs are receipts, not the results themselves: Snakemake deletes outputs before it makes them again, and
# rectify.py keeps an earlier page until the new one is complete. A failure is a log, because Snakemake keeps logs.


def rectify(stop_after):
    """The command of a rule, as the words after those of record.py."""
    step = {"place": "place", "unwrap": "sheet", None: "page"}[stop_after]

    def command(wildcards, threads):
        document = DOCUMENTS[wildcards.document]
        words = [PYTHON, str(ROOT / "headless" / "rectify.py"), str(document.folder)]
        words += ["-o", f"{OUT}/{wildcards.document}", "--resume", f"--threads={threads}"]
        return words + document.arguments(step) + ([f"--stop-after={stop_after}"] if stop_after else [])

    return command


def document_of(wildcards):
    return DOCUMENTS[wildcards.document]


def memory_mb(base, per_photo_mb):
    """Memory for a job by the size of its photo files, and more at each further try."""
    return lambda wildcards, input, attempt: int(attempt * (base + per_photo_mb * input.size_mb))


rule place:
    input:
        photos=lambda wildcards: document_of(wildcards).photos(),
        named=lambda wildcards: document_of(wildcards).inputs("place"),
    output:
        f"{OUT}/{{document}}/batch/place.json",
    log:
        f"{OUT}/{{document}}/batch/place.log",
        f"{OUT}/{{document}}/batch/place.failed.json",
    params:
        folder=f"{OUT}/{{document}}",
        command=rectify("place"),
    threads: config["threads"]
    resources:
        mem_mb=memory_mb(1000, 0),
    shell:
        "{PYTHON:q} {SCRIPTS:q}/record.py {params.folder:q} place -- {params.command:q}"


rule sheet:
    input:
        placed=rules.place.output,
        photos=rules.place.input.photos,
        named=lambda wildcards: document_of(wildcards).inputs("sheet"),
    output:
        f"{OUT}/{{document}}/batch/sheet.json",
    log:
        f"{OUT}/{{document}}/batch/sheet.log",
        f"{OUT}/{{document}}/batch/sheet.failed.json",
    params:
        folder=f"{OUT}/{{document}}",
        command=rectify("unwrap"),
    threads: config["threads"]
    resources:
        mem_mb=memory_mb(1000, 0),
    shell:
        "{PYTHON:q} {SCRIPTS:q}/record.py {params.folder:q} sheet -- {params.command:q}"


rule page:
    input:
        sheet=rules.sheet.output,
        photos=rules.place.input.photos,
        named=lambda wildcards: document_of(wildcards).inputs("page"),
    output:
        f"{OUT}/{{document}}/batch/page.json",
    log:
        f"{OUT}/{{document}}/batch/page.log",
        f"{OUT}/{{document}}/batch/page.failed.json",
    params:
        folder=f"{OUT}/{{document}}",
        command=rectify(None),
    threads: config["threads"]
    resources:
        mem_mb=memory_mb(1000, 0),
    shell:
        "{PYTHON:q} {SCRIPTS:q}/record.py {params.folder:q} page -- {params.command:q}"
