# From photos to the page, in three rules, each of which stops after its own stages of headless/rectify.py.
#
# The outputs are receipts, not the results themselves: Snakemake deletes outputs before it makes them again, and
# rectify.py keeps an earlier page until the new one is complete. A failure is a log, because Snakemake keeps logs.


def of_document(what, *arguments):
    """A function of wildcards, as Snakemake takes it, that asks the document; such params make a rule run again."""
    return lambda wildcards: getattr(DOCUMENTS[wildcards.document], what)(*arguments)


def photos_of(wildcards):
    return str(DOCUMENTS[wildcards.document].folder)


def memory_mb(base, per_photo_mb):
    """Memory for a job by the size of its photo files, and more at each further try."""
    return lambda wildcards, input, attempt: int(attempt * (base + per_photo_mb * input.size_mb))


RECTIFY = (
    "{PYTHON:q} {SCRIPTS:q}/record.py {params.results:q} {rule} -- {PYTHON:q} {ROOT:q}/headless/rectify.py "
    "{params.photos:q} -o {params.results:q} --resume --threads={threads} {params.options:q}"
)


rule place:
    input:
        photos=of_document("photos"),
        named=of_document("inputs", "place"),
    output:
        f"{OUT}/{{document}}/batch/place.json",
    log:
        f"{OUT}/{{document}}/batch/place.log",
        f"{OUT}/{{document}}/batch/place.failed.json",
    params:
        photos=photos_of,
        others=of_document("others"),
        results=f"{OUT}/{{document}}",
        options=of_document("arguments", "place"),
    threads: config["threads"]
    resources:
        mem_mb=memory_mb(1000, 0),
    shell:
        f"{RECTIFY} --stop-after=place"


rule sheet:
    input:
        placed=rules.place.output,
        photos=rules.place.input.photos,
        named=of_document("inputs", "sheet"),
    output:
        f"{OUT}/{{document}}/batch/sheet.json",
    log:
        f"{OUT}/{{document}}/batch/sheet.log",
        f"{OUT}/{{document}}/batch/sheet.failed.json",
    params:
        photos=photos_of,
        results=f"{OUT}/{{document}}",
        options=of_document("arguments", "sheet"),
    threads: config["threads"]
    resources:
        mem_mb=memory_mb(1000, 0),
    shell:
        f"{RECTIFY} --stop-after=unwrap"


rule page:
    input:
        sheet=rules.sheet.output,
        photos=rules.place.input.photos,
        named=of_document("inputs", "page"),
    output:
        f"{OUT}/{{document}}/batch/page.json",
    log:
        f"{OUT}/{{document}}/batch/page.log",
        f"{OUT}/{{document}}/batch/page.failed.json",
    params:
        photos=photos_of,
        results=f"{OUT}/{{document}}",
        options=of_document("arguments", "page"),
    threads: config["threads"]
    resources:
        mem_mb=memory_mb(1000, 0),
    shell:
        RECTIFY
