# A METS workspace for each page, with its text if that is asked for too.


rule handover:
    input:
        rules.page.output,
        *(rules.text.output if config["text"] else []),
    output:
        f"{OUT}/{{document}}/handover/mets.xml",
    params:
        document=f"{OUT}/{{document}}",
    resources:
        mem_mb=1000,
    shell:
        "{sys.executable:q} {SCRIPTS:q}/handover.py {params.document:q}"
