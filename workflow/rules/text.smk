# A text layer for each page, and the words in its photos. As in rectify.smk, the output is a receipt: text.py itself
# keeps the earlier files until the new ones are complete, and what somebody has corrected.


rule text:
    input:
        rules.page.output,
    output:
        f"{OUT}/{{document}}/batch/text.json",
    log:
        f"{OUT}/{{document}}/batch/text.log",
        f"{OUT}/{{document}}/batch/text.failed.json",
    params:
        document=f"{OUT}/{{document}}",
        command=lambda wildcards: [
            sys.executable,
            str(SCRIPTS / "text.py"),
            f"{OUT}/{wildcards.document}",
            f"--languages={DOCUMENTS[wildcards.document].languages or 'eng'}",
        ],
    resources:
        mem_mb=1000,
    shell:
        RECORD + " {params.command:q}"
