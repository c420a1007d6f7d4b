//! Kubernetes: an Indexed Job of `batch/v1` with the script in a ConfigMap, as JSON, and a second Job that merges the parts of a still.

use std::fmt::Write as _;

use serde_json::{Value, json};

use rayframe::error::{Error, Result};
use rayframe::regression::suite::shell_quoted;

use super::job_files::{JobFile, sha256};
use super::job_plan::JobPlan;
use super::task_script::{MERGE, SHOT_FILE, TASK_SCRIPT, numbered_files};

/// Where the ConfigMap is mounted.
const JOB_FOLDER: &str = "/etc/rayframe-job";
/// Largest content of a ConfigMap, with space for its names.
const MAX_CONFIG_BYTES: usize = (1 << 20) - 4096;
/// Characters of the shot's name in the names of objects: a domain label with a hash, `-merge` and the index of a pod has at most 63.
const MAX_NAME: usize = 40;
/// Digits of the hash in the names of objects.
const HASH_DIGITS: usize = 8;
/// Exit codes of failures that repeat themselves.
const PERMANENT: [i32; 6] = [2, 65, 66, 70, 73, 77];

/// `job.k8s.json`, `submit.sh`, `tasks.txt`, and for stills `merge.k8s.json`.
///
/// # Errors
/// [`Error::Usage`] for more tasks than a ConfigMap describes.
pub(super) fn files(plan: &JobPlan) -> Result<Vec<JobFile>> {
    let scripts = numbered_files(plan);
    if scripts.iter().map(|file| file.content.len()).sum::<usize>() > MAX_CONFIG_BYTES {
        let count = plan.tasks.len();
        let remedy =
            if plan.parts.is_empty() { "raise --chunk" } else { "divide the still into fewer parts" };
        return Err(Error::usage(format!("{count} tasks need more than the 1 MiB of a ConfigMap; {remedy}")));
    }
    let name = name(plan, &scripts);
    let data: serde_json::Map<String, Value> =
        scripts.iter().map(|file| (file.name.to_owned(), json!(file.content))).collect();
    let config = json!({
        "apiVersion": "v1", "kind": "ConfigMap",
        "metadata": { "name": name, "labels": labels(&name) },
        "data": data,
    });
    let mut files = vec![manifest("job.k8s.json", &json!([config, indexed_job(plan, &name)]))?];
    if !plan.parts.is_empty() {
        files.push(manifest("merge.k8s.json", &json!([merge_job(plan, &name)]))?);
    }
    files.push(JobFile { name: "submit.sh", content: submit(plan, &name) });
    files.push(JobFile { name: "tasks.txt", content: plan.task_list() });
    Ok(files)
}

fn manifest(name: &'static str, items: &Value) -> Result<JobFile> {
    let list = json!({ "apiVersion": "v1", "kind": "List", "items": items });
    let text = serde_json::to_string_pretty(&list)
        .map_err(|error| Error::Internal { message: error.to_string() })?;
    Ok(JobFile { name, content: format!("{text}\n") })
}

/// A name by RFC 1123 that other jobs do not have: `kubectl apply` runs nothing for a job that equals an earlier one but for its ConfigMap, and
/// refuses one of the same name with another image, other volumes or retries.
fn name(plan: &JobPlan, scripts: &[JobFile]) -> String {
    let own = plan.plain_name(MAX_NAME).to_ascii_lowercase().replace(['_', '.'], "-");
    let scripts = scripts.iter().map(|file| file.content.clone());
    let jobs = [indexed_job(plan, ""), merge_job(plan, "")].map(|job| job.to_string());
    let hashes: Vec<String> = scripts.chain(jobs).map(|content| sha256(&content)).collect();
    let hash = sha256(&hashes.concat());
    format!("{own}-{}", hash.get(..HASH_DIGITS).unwrap_or(&hash))
}

fn labels(name: &str) -> Value {
    json!({ "app.kubernetes.io/name": "rayframe", "app.kubernetes.io/instance": name })
}

fn indexed_job(plan: &JobPlan, name: &str) -> Value {
    let count = plan.tasks.len();
    let mut job = job(plan, (name, name), "${JOB_COMPLETION_INDEX}");
    let spec = &mut job["spec"];
    spec["completionMode"] = json!("Indexed");
    spec["completions"] = json!(count);
    spec["parallelism"] = json!(plan.at_most.map_or(count, |most| count.min(most as usize)));
    spec["backoffLimitPerIndex"] = json!(plan.retries);
    spec["maxFailedIndexes"] = json!(count);
    spec["podFailurePolicy"] = failure_policy("FailIndex");
    job
}

fn merge_job(plan: &JobPlan, name: &str) -> Value {
    let mut job = job(plan, (&format!("{name}-merge"), name), MERGE);
    job["spec"]["backoffLimit"] = json!(plan.retries);
    job["spec"]["podFailurePolicy"] = failure_policy("FailJob");
    job
}

/// Failures that repeat themselves end the task. Evictions do not count, other failures do.
fn failure_policy(action: &str) -> Value {
    json!({ "rules": [
        { "action": action, "onExitCodes": { "containerName": "rayframe", "operator": "In", "values": PERMANENT } },
        { "action": "Ignore", "onPodConditions": [{ "type": "DisruptionTarget", "status": "True" }] },
    ] })
}

/// A job that runs `task`, with its name and that of the ConfigMap.
fn job(plan: &JobPlan, (name, config): (&str, &str), task: &str) -> Value {
    let needs = json!({ "cpu": plan.resources.threads.to_string(), "memory": format!("{}Mi", plan.resources.memory_mib()) });
    let mut mounts = vec![json!({ "name": "job", "mountPath": JOB_FOLDER, "readOnly": true })];
    let mut volumes = vec![json!({ "name": "job", "configMap": { "name": config } })];
    for (index, (claim, path)) in plan.claims.iter().enumerate() {
        let volume = format!("claim-{index}");
        mounts.push(json!({ "name": volume, "mountPath": path }));
        volumes.push(json!({ "name": volume, "persistentVolumeClaim": { "claimName": claim } }));
    }
    let image = plan.image.clone().unwrap_or_else(|| plan.version.replace(' ', ":"));
    let script = format!("exec sh {JOB_FOLDER}/{TASK_SCRIPT} \"{task}\" {JOB_FOLDER}/{SHOT_FILE}");
    json!({
        "apiVersion": "batch/v1", "kind": "Job",
        "metadata": { "name": name, "labels": labels(config) },
        "spec": { "template": {
            "metadata": { "labels": labels(config) },
            "spec": {
                "restartPolicy": "Never",
                "containers": [{
                    "name": "rayframe",
                    "image": image,
                    "command": ["/bin/sh", "-c", script],
                    "resources": { "requests": needs, "limits": needs },
                    "volumeMounts": mounts,
                }],
                "volumes": volumes,
            },
        } },
    })
}

fn submit(plan: &JobPlan, name: &str) -> String {
    let at = |name: &str| shell_quoted(&format!("{}/{name}", plan.folder));
    let mut text = format!(
        "#!/bin/sh\n# Written by {}. Submits the job; options of kubectl may follow\nset -eu\nkubectl apply -f {} \"$@\"\n",
        plan.version,
        at("job.k8s.json")
    );
    if !plan.parts.is_empty() {
        let _ = write!(
            text,
            "kubectl wait --for=condition=complete --timeout=-1s job/{name} \"$@\"\nkubectl apply -f {} \"$@\"\n",
            at("merge.k8s.json")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::job_plan::Pin;
    use super::super::test_plan::{plan, still};
    use super::*;

    fn items(plan: &JobPlan, name: &str) -> Vec<Value> {
        let files = files(plan).unwrap();
        let file = files.iter().find(|file| file.name == name).unwrap();
        let list: Value = serde_json::from_str(&file.content).unwrap();
        list["items"].as_array().unwrap().clone()
    }

    #[test]
    fn the_job_has_an_index_for_each_task() {
        let items = items(&plan(), "job.k8s.json");
        let (config, spec) = (&items[0], &items[1]["spec"]);
        let name = config["metadata"]["name"].as_str().unwrap();
        assert!(name.starts_with("it-s--new-"), "{name}");
        assert!(config["data"]["task.sh"].as_str().unwrap().contains("'1') set -- '--frames=3'"));
        assert_eq!([&spec["completions"], &spec["parallelism"], &spec["backoffLimitPerIndex"]], [2, 2, 3]);
        assert_eq!(
            spec["podFailurePolicy"]["rules"][0]["onExitCodes"]["values"],
            json!([2, 65, 66, 70, 73, 77])
        );
        let container = &spec["template"]["spec"]["containers"][0];
        assert_eq!(container["image"], "rayframe:0.1.0");
        assert_eq!(container["resources"]["requests"], json!({ "cpu": "4", "memory": "300Mi" }));
        assert_eq!(container["volumeMounts"][1], json!({ "name": "claim-0", "mountPath": "/shots" }));
    }

    #[test]
    fn a_second_job_merges() {
        let items = items(&still(), "merge.k8s.json");
        let name = items[0]["metadata"]["name"].as_str().unwrap();
        assert!(name.starts_with("s-") && name.ends_with("-merge"), "{name}");
        assert!(items[0]["spec"]["completionMode"].is_null());
    }

    /// Names of the ConfigMap and of both Jobs, which `submit.sh` and the volumes name, too.
    fn names_of(plan: &JobPlan) -> Vec<String> {
        let files = files(plan).unwrap();
        let submit = &files.iter().find(|file| file.name == "submit.sh").unwrap().content;
        let [job, merge] = ["job.k8s.json", "merge.k8s.json"].map(|name| items(plan, name));
        let named = |item: &Value| item["metadata"]["name"].as_str().unwrap().to_owned();
        let (config, indexed) = (named(&job[0]), named(&job[1]));
        assert!(submit.contains(&format!(" job/{indexed} ")), "{submit}");
        for item in [&job[1], &merge[0]] {
            assert_eq!(item["spec"]["template"]["spec"]["volumes"][0]["configMap"]["name"], *config);
        }
        vec![config, indexed, named(&merge[0])]
    }

    #[test]
    fn jobs_that_differ_in_anything_have_other_names() {
        let long = JobPlan { name: "A_very.long name".repeat(9), ..still() };
        let other_frame = JobPlan { pin: Pin { frame: 2, ..long.pin.clone() }, ..long.clone() };
        let other_shot = JobPlan { shot_file: "resolution = \"32x18\"\n".to_owned(), ..long.clone() };
        let other_retries = JobPlan { retries: long.retries + 1, ..long.clone() };
        let other_claims =
            JobPlan { claims: vec![("other".to_owned(), "/other".to_owned())], ..long.clone() };
        let names = names_of(&long);
        assert_eq!(names_of(&long), names);
        for other in [other_frame, other_shot, other_retries, other_claims].map(|plan| names_of(&plan)) {
            for (other, name) in other.iter().zip(&names) {
                assert_ne!(other, name);
            }
        }
        for name in names {
            // With the index of a pod a name is still a label.
            assert!(name.len() + "-99999".len() <= 63, "{name}");
            assert!(name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'), "{name}");
        }
    }

    #[test]
    fn jobs_that_no_config_map_holds_are_refused() {
        for (mut large, remedy) in [(plan(), "raise --chunk"), (still(), "fewer parts")] {
            large.tasks = vec![large.tasks[0].clone(); 30_000];
            let error = files(&large).unwrap_err();
            assert!(error.exit_code() == 2 && error.to_string().ends_with(remedy), "{error}");
        }
    }
}
