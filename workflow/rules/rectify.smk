# From photos to the page, in three rules, each of which stops after its own stages of headless/rectify.py.
#
# The outputs are receipts, not the results themselves: Snakemake deletes outputs before it makes them again, and
# rectify.py keeps an earlier page until the new one is complete. A failure is a log, because Snakemake keeps logs.


def of_document(what, *arguments):
    """A function of wildcards, as Snakemake takes it, that asks the document; such params make a rule run again."""
    return lambda wildcards: getattr(DOCUMENTS[wildcards.document], what)(*arguments)


def photos_of(wildcards):
    return str(DOCUMENTS[wildcards.document].folder)


def all_options(wildcards, threads):
    """All options of a document, so that a wrong one is found before its photos are placed.

    Snakemake does not compare params that depend on threads, so an option makes only those rules run again whose params
    `options` name it.
    """
    return [f"--threads={threads}", *DOCUMENTS[wildcards.document].arguments("page")]


def memory_to_place(wildcards, threads, attempt):
    """Memory in MB. Placing photos of 2000 pixels and more took 1026 MB with one thread and 1895 MB with two."""
    return attempt * (250 + 900 * threads)


def memory_for_pixels(wildcards, attempt):
    """Memory in MB of the other rules, by the size of the photo files.

    Seven photos of 8 megapixels (4 MB) took 551 MB at most, eight of 3 megapixels (6 MB) 537 MB, and 733 MB with two
    threads, six of 0.3 megapixels 434 MB.
    """
    return int(attempt * (500 + 60 * DOCUMENTS[wildcards.document].megabytes()))


RECTIFY = (
    RECORD + " {PYTHON:q} {ROOT:q}/headless/rectify.py {params.photos:q} -o {params.document:q} --resume {params.all:q}"
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
        document=f"{OUT}/{{document}}",
        options=of_document("arguments", "place"),
        all=all_options,
    threads: config["threads"]
    resources:
        mem_mb=memory_to_place,
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
        document=f"{OUT}/{{document}}",
        options=of_document("arguments", "sheet"),
        all=all_options,
    threads: config["threads"]
    resources:
        mem_mb=memory_for_pixels,
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
        document=f"{OUT}/{{document}}",
        options=of_document("arguments", "page"),
        all=all_options,
    threads: config["threads"]
    resources:
        mem_mb=memory_for_pixels,
    shell:
        RECTIFY
