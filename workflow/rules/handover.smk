# A METS workspace for each page, with its text if that is asked for too.


rule handover:
    input:
        rules.page.output,
        rules.text.output if config["text"] else [],
    output:
        f"{OUT}/{{document}}/batch/handover.json",
    log:
        f"{OUT}/{{document}}/batch/handover.log",
        f"{OUT}/{{document}}/batch/handover.failed.json",
    params:
        document=f"{OUT}/{{document}}",
        command=lambda wildcards: [sys.executable, str(SCRIPTS / "handover.py"), f"{OUT}/{wildcards.document}"],
    resources:
        mem_mb=1000,
    shell:
        RECORD + " {params.command:q}"
