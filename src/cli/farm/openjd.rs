//! Open Job Description (2023-09): a template that holds its scripts, and the files that AWS Deadline Cloud reads beside it.
//!
//! `template.json`: steps of up to 1024 tasks, the most that a list of values may have, and a step that merges the parts of a still.
//! `parameter_values.json` and `asset_references.json`: values of parameters, and job attachments. `parameters.json`: the same values for
//! `openjd run`.

use serde_json::{Value, json};

use rayframe::error::{Error, Result};

use super::asset_folders::AssetFolder;
use super::job_files::JobFile;
use super::job_plan::{JobPlan, Task};
use super::task_script::{MERGE, ScriptForm, TRANSIENT, run_and_wait, script};

/// Most values of a parameter of tasks.
const MAX_VALUES: usize = 1024;
/// Most steps of a job.
const MAX_STEPS: usize = 100;
/// Most characters of a value.
const MAX_CHARACTERS: usize = 1024;
/// Seconds between SIGTERM and SIGKILL.
const NOTIFY_SECONDS: u32 = 30;

/// The files of a job.
///
/// # Errors
/// [`Error::Usage`] for more tasks than a template may have, and for names with `{{`, which templates replace.
pub(super) fn files(plan: &JobPlan) -> Result<Vec<JobFile>> {
    let steps = steps(plan)?;
    let mut template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": plan.plain_name(128),
        "description": format!("Written by {}", plan.version),
        "parameterDefinitions": [
            path_parameter("Scene", "FILE", "IN", "The scene"),
            path_parameter("OutputFolder", "DIRECTORY", "OUT", "Folder of the frames"),
            text_parameter("Rayframe", &plan.program, "Rayframe on the workers"),
        ],
        "jobEnvironments": [{
            "name": "Rayframe",
            "variables": {
                "RAYFRAME": "{{Param.Rayframe}}",
                "RAYFRAME_SCENE": "{{Param.Scene}}",
                "RAYFRAME_OUTPUT_FOLDER": "{{Param.OutputFolder}}",
            },
        }],
        "steps": steps,
    });
    let mut values = vec![
        json!({ "name": "Scene", "value": plan.scene }),
        json!({ "name": "OutputFolder", "value": plan.output_folder }),
        json!({ "name": "deadline:maxRetriesPerTask", "value": 0 }),
    ];
    values.extend(plan.at_most.map(|most| json!({ "name": "deadline:maxWorkerCount", "value": most })));
    // openjd-cli reads parameters by their names.
    let mut named = json!({ "Scene": plan.scene, "OutputFolder": plan.output_folder });
    for (definition, variable, value) in asset_parameters(plan) {
        let name = definition["name"].clone();
        named[name.as_str().unwrap_or_default()] = json!(value);
        template["jobEnvironments"][0]["variables"][variable] =
            json!(format!("{{{{Param.{}}}}}", name.as_str().unwrap_or_default()));
        values.push(json!({ "name": name, "value": value }));
        template["parameterDefinitions"]
            .as_array_mut()
            .into_iter()
            .for_each(|list| list.push(definition.clone()));
    }
    let values = json!({ "parameterValues": values });
    let assets = json!({ "assetReferences": {
        "inputs": { "filenames": plan.assets, "directories": [] },
        "outputs": { "directories": [plan.output_folder] },
        "referencedPaths": [],
    } });
    Ok(vec![
        json_file("template.json", &template)?,
        json_file("parameter_values.json", &values)?,
        json_file("parameters.json", &named)?,
        json_file("asset_references.json", &assets)?,
    ])
}

/// Parameters for files that settings name, for the denoiser and for the cache: definition, environment variable, value. The files themselves are asset
/// references.
fn asset_parameters(plan: &JobPlan) -> Vec<(Value, String, &str)> {
    let folder = |asset: &'_ AssetFolder| {
        let description = format!("Folder of what the setting {} names", asset.setting);
        path_parameter(asset.parameter, "DIRECTORY", "NONE", &description)
    };
    let folders = plan.asset_folders.iter().map(|asset| (folder(asset), asset.variable(), &*asset.folder));
    let oidn = plan.oidn.iter().map(|program| {
        let definition =
            text_parameter("Oidn", program, "The program oidnDenoise on the workers, or its folder");
        (definition, "RAYFRAME_OIDN".to_owned(), &**program)
    });
    let cache = plan.asset_cache.iter().map(|(folder, _)| {
        let definition = text_parameter("AssetCache", folder, "Folder of decoded assets on the workers");
        (definition, "RAYFRAME_ASSET_CACHE".to_owned(), &**folder)
    });
    folders.chain(oidn).chain(cache).collect()
}

fn json_file(name: &'static str, value: &Value) -> Result<JobFile> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Error::Internal { message: error.to_string() })?;
    Ok(JobFile { name, content: format!("{text}\n") })
}

fn path_parameter(name: &str, kind: &str, flow: &str, description: &str) -> Value {
    json!({ "name": name, "type": "PATH", "objectType": kind, "dataFlow": flow, "description": description })
}

fn text_parameter(name: &str, default: &str, description: &str) -> Value {
    json!({ "name": name, "type": "STRING", "default": default, "description": description })
}

fn steps(plan: &JobPlan) -> Result<Vec<Value>> {
    let groups: Vec<&[Task]> = plan.tasks.chunks(MAX_VALUES).collect();
    if groups.len() >= MAX_STEPS {
        let count = plan.tasks.len();
        return Err(Error::usage(format!("{count} tasks are more than a template may have; raise --chunk")));
    }
    let name =
        |index: usize| if groups.len() == 1 { "Render".to_owned() } else { format!("Render{}", index + 1) };
    let mut steps = Vec::new();
    for (index, tasks) in groups.iter().enumerate() {
        let keys: Vec<String> = tasks.iter().enumerate().map(|(index, task)| key(index, task)).collect();
        let mut step = step(plan, &name(index), ScriptForm { keys: &keys, tasks, progress: "openjd" })?;
        step["parameterSpace"] =
            json!({ "taskParameterDefinitions": [{ "name": "Task", "type": "STRING", "range": keys }] });
        steps.push(step);
    }
    if !plan.parts.is_empty() {
        let mut merge = step(plan, "Merge", ScriptForm { keys: &[], tasks: &[], progress: "openjd" })?;
        merge["script"]["actions"]["onRun"]["args"] =
            json!(["{{Task.File.Run}}", MERGE, "{{Task.File.Shot}}"]);
        merge["dependencies"] = (0..groups.len()).map(|index| json!({ "dependsOn": name(index) })).collect();
        steps.push(merge);
    }
    Ok(steps)
}

/// The value of the parameter: the name of the task, or its number where that is too long.
fn key(index: usize, task: &Task) -> String {
    if task.name.chars().count() <= MAX_CHARACTERS { task.name.clone() } else { format!("task {index}") }
}

fn step(plan: &JobPlan, name: &str, form: ScriptForm<'_>) -> Result<Value> {
    let (task, shot) = (script(plan, form), &plan.shot_file);
    if task.contains("{{") || shot.contains("{{") {
        return Err(Error::usage("a name holds {{, which Open Job Description replaces; rename the file"));
    }
    let memory = plan.resources.memory_mib();
    Ok(json!({
        "name": name,
        "hostRequirements": { "amounts": [
            { "name": "amount.worker.vcpu", "min": plan.resources.threads },
            { "name": "amount.worker.memory", "min": memory },
        ] },
        "script": {
            "embeddedFiles": [
                { "name": "Task", "type": "TEXT", "filename": "task.sh", "data": task },
                { "name": "Run", "type": "TEXT", "filename": "run.sh", "data": repeating(plan) },
                { "name": "Shot", "type": "TEXT", "filename": "shot.toml", "data": shot },
            ],
            "actions": { "onRun": {
                "command": "sh",
                "args": ["{{Task.File.Run}}", "{{Task.Param.Task}}", "{{Task.File.Shot}}"],
                "cancelation": { "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": NOTIFY_SECONDS },
            } },
        },
    }))
}

/// A script that repeats a task after failures that may pass: templates have no retries by exit code.
fn repeating(plan: &JobPlan) -> String {
    let run = run_and_wait("sh '{{Task.File.Task}}' \"$@\"");
    format!(
        "#!/bin/sh\n# Written by {}. Repeats a task after failures that may pass\nset -u\nattempt=0\nwhile :; do\n{run}\
         [ -z \"$ended\" ] || exit \"$code\"\ncase $code in\n{TRANSIENT}) ;;\n*) exit \"$code\" ;;\nesac\n\
         [ \"$attempt\" -lt {} ] || exit \"$code\"\nattempt=$((attempt + 1))\n\
         echo \"openjd_status: exit code $code, attempt $((attempt + 1))\"\nsleep \"$attempt\"\ndone\n",
        plan.version, plan.retries
    )
}

#[cfg(test)]
mod tests {
    use super::super::test_plan::{plan, still};
    use super::*;

    fn template(plan: &JobPlan) -> Value {
        let files = files(plan).unwrap();
        let file = files.iter().find(|file| file.name == "template.json").unwrap();
        serde_json::from_str(&file.content).unwrap()
    }

    #[test]
    fn tasks_are_values_of_a_parameter() {
        let template = template(&plan());
        assert_eq!(template["specificationVersion"], "jobtemplate-2023-09");
        let steps = template["steps"].as_array().unwrap();
        assert_eq!((steps.len(), &steps[0]["name"]), (1, &json!("Render")));
        assert_eq!(steps[0]["parameterSpace"]["taskParameterDefinitions"][0]["range"], json!(["1-2", "3"]));
        assert_eq!(steps[0]["hostRequirements"]["amounts"][1]["min"], 300);
        let data = steps[0]["script"]["embeddedFiles"][0]["data"].as_str().unwrap();
        assert!(
            data.contains("'1-2') set -- '--frames=1-2'") && data.contains("--progress openjd"),
            "{data}"
        );
    }

    #[test]
    fn workers_are_limited_where_it_is_asked_for() {
        let limit = |plan: &JobPlan| {
            let files = files(plan).unwrap();
            let file = files.iter().find(|file| file.name == "parameter_values.json").unwrap();
            let values: Value = serde_json::from_str(&file.content).unwrap();
            let values = values["parameterValues"].as_array().unwrap().clone();
            values.into_iter().find(|value| value["name"] == "deadline:maxWorkerCount")
        };
        assert_eq!(limit(&plan()), Some(json!({ "name": "deadline:maxWorkerCount", "value": 7 })));
        assert_eq!(limit(&still()), None);
    }

    #[test]
    fn tiles_are_merged_in_a_step_that_depends_on_them() {
        let template = template(&still());
        let merge = &template["steps"][1];
        assert_eq!(merge["dependencies"], json!([{ "dependsOn": "Render" }]));
        assert_eq!(merge["script"]["actions"]["onRun"]["args"][1], "merge");
    }

    #[test]
    fn long_jobs_have_several_steps() {
        let mut long = plan();
        long.tasks = vec![long.tasks[0].clone(); 1025];
        let template = template(&long);
        assert_eq!(template["steps"][1]["name"], "Render2");
        long.tasks = vec![long.tasks[0].clone(); 200_000];
        assert_eq!(files(&long).unwrap_err().exit_code(), 2);
    }

    #[test]
    fn what_a_template_replaces_is_refused() {
        let mut odd = plan();
        odd.scene = "/shots/{{Param.Scene}}.glb".to_owned();
        assert_eq!(files(&odd).unwrap_err().exit_code(), 2);
    }
}
